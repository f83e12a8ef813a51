#include "app/view/panel.h"

#include <fmt/format.h>

#include <array>
#include <cfloat>
#include <string_view>
#include <utility>
#include <vector>

#include "app/view/option_widgets.h"
#include "base/log.h"
#include "output/aov.h"

namespace latelight::app {

namespace {

using view::SetSplit;
using view::Side;

void line(const std::string& text) {
  ImGui::TextUnformatted(text.c_str());
}

bool section(const char* title, bool open) {
  return ImGui::CollapsingHeader(title, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

constexpr std::pair<const char*, const char*> kHelp[] = {
    {"drag", "orbit; look around when flying"},
    {"right, middle, Shift drag", "pan"},
    {"wheel", "zoom toward the pointer; change the speed when flying"},
    {"click, Esc", "select, clear the selection"},
    {"P, arrows, Shift+arrows", "inspect a pixel, move by 1 and by 10 pixels; P or Esc ends it"},
    {"Enter", "select the object at the inspected pixel or at the center"},
    {"arrows, Shift+arrows", "orbit, pan"},
    {"+ -", "zoom in, zoom out"},
    {"1 3 7", "view from the front, right, top"},
    {"Home, F", "frame the scene, frame the selection"},
    {"O", "fly or orbit; W A S D Q E fly"},
    {"space", "play or pause"},
    {"F2, Esc", "move the keyboard focus to the panel (arrows, space, Enter to type), and back to the image"},
    {"H, L", "hide the panel, show light handles and the sun dial"},
    {"Tab, arrows, Shift+arrows", "select a light handle, move it by 8 pixels and by 1; Esc deselects it"},
    {"[ ]", "move the divider"},
    {"Ctrl+S Ctrl+C Ctrl+R", "screenshot, copy command, reload"},
    {"Ctrl+N Ctrl+W", "open another window, close this one"}};

// --- outputs and options ---------------------------------------------------------------------------------------------

void drawOutputs(const view::State& state, Side side, const Send& send) {
  const std::string& shown = state.choices[static_cast<int>(side)].output;
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##output", shown.c_str(), ImGuiComboFlags_HeightLarge)) return;
  const auto offer = [&](const std::string& name, std::string_view description) {
    if (ImGui::Selectable(name.c_str(), name == shown)) send(view::ShowOutput{name, side});
    explain(std::string(description));
  };
  offer("picture", "The rendered image");
  for (const output::AovInfo& aov : output::aovs()) offer(std::string(aov.name), aov.description);
  offer("lights", "Lights tested and used, side by side");
  offer("sheet", "All outputs except raw, samples and raster-*");
  offer("targets", "All targets of the layout");
  for (const std::string& target : state.targets) offer("target:" + target, "A target of the layout");
  ImGui::EndCombo();
}

void drawSplit(const view::State& state, PanelMemory& memory, const Send& send) {
  SetSplit split = state.split;
  int mode = split.mode;
  bool edited = false;
  for (const auto& [name, value] : {std::pair("one", 0), std::pair("split", 1), std::pair("difference", 2)}) {
    if (value) ImGui::SameLine();
    edited |= ImGui::RadioButton(name, &mode, value);
  }
  split.mode = static_cast<SetSplit::Mode>(mode);
  auto at = static_cast<float>(split.at), amplification = static_cast<float>(split.amplification);
  if (split.mode == SetSplit::Slider) edited |= ImGui::SliderFloat("slider", &at, 0, 1, "%.3f");
  if (split.mode == SetSplit::Difference)
    edited |= ImGui::SliderFloat("amplified", &amplification, 1, 256, "%.0f", ImGuiSliderFlags_Logarithmic);
  split.at = at, split.amplification = amplification;
  if (edited) send(split);
  if (split.mode == SetSplit::Off) {
    memory.side = Side::Left;
    return;
  }
  int side = static_cast<int>(memory.side);
  ImGui::AlignTextToFramePadding();
  line("Options of");
  for (const auto& [name, value] : {std::pair("left", 0), std::pair("right", 1)}) {
    ImGui::SameLine();
    ImGui::RadioButton(name, &side, value);
  }
  memory.side = static_cast<Side>(side);
}

void drawVariants(const view::State& state, const Send& send) {
  const auto label = [](const std::string& name) { return name.empty() ? "(the default variant)" : printable(name); };
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##variant", label(state.variant).c_str())) return;
  if (ImGui::Selectable(label("").c_str(), state.variant.empty())) send(view::UseVariant{""});
  for (const std::string& name : state.variants)
    if (ImGui::Selectable(label(name).c_str(), name == state.variant)) send(view::UseVariant{name});
  ImGui::EndCombo();
}

void drawCameras(const view::State& state, const Send& send) {
  const auto label = [&](size_t index) { return fmt::format("{} {}", index, printable(state.cameras[index])); };
  const std::string shown = state.steered          ? "(steered)"
                            : state.camera.empty() ? "(the first)"
                            : state.cameraIndex    ? label(*state.cameraIndex)
                                                   : printable(state.camera);
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 8);
  if (ImGui::BeginCombo("##camera", shown.c_str())) {
    if (ImGui::Selectable("(the first)", shown == "(the first)")) send(view::UseCamera{""});
    for (size_t i = 0; i < state.cameras.size(); ++i)
      if (ImGui::Selectable(label(i).c_str())) send(view::UseCamera{fmt::format("#{}", i)});
    ImGui::EndCombo();
  }
  ImGui::SameLine();
  bool flies = state.navigation == view::Navigation::Fly;
  if (ImGui::Checkbox("fly (O)", &flies))
    send(view::SetNavigation{flies ? view::Navigation::Fly : view::Navigation::Orbit});
  if (ImGui::Button("frame all (Home)")) send(view::Key{"Home", true});
  ImGui::SameLine();
  ImGui::BeginDisabled(!state.selected);
  if (ImGui::Button("frame selection (F)")) send(view::Key{"f", true});
  ImGui::EndDisabled();
}

void drawTime(const view::State& state, const Send& send) {
  if (ImGui::Button(state.playing ? "stop" : "play")) send(view::Play{!state.playing});
  ImGui::SameLine();
  auto time = static_cast<float>(state.time.value_or(0));
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##time", &time, 0, static_cast<float>(state.duration), state.time ? "%.3f s" : "at rest"))
    for (const Side side : {Side::Left, Side::Right}) send(view::SetOption{"time", fmt::format("{:.4g}", time), side});
}

void drawLights(const view::State& state, PanelMemory& memory, const Send& send) {
  ImGui::Checkbox("handles in the picture, and the sun's dial (L)", &memory.handles);
  if (state.lightsMoved) ImGui::TextWrapped("Lights were moved: the command line uses their positions in the file.");
  for (uint32_t i = 0; i < state.lights.size() && i < 64; ++i) {
    const view::LightState& light = state.lights[i];
    std::array<double, 3> position = light.position;
    ImGui::PushID(static_cast<int>(i));
    const std::string label = printable(light.name.empty() ? light.type : light.name);
    if (ImGui::DragScalarN(label.c_str(), ImGuiDataType_Double, position.data(), 3, 0.02f, nullptr, nullptr, "%.3g"))
      send(view::MoveLight{i, position});
    ImGui::PopID();
  }
}

void drawEnvironment(PanelMemory& memory, const Send& send) {
  if (editText("##environment", memory.environment)) send(view::UseEnvironment{memory.environment});
  explain(
      "A .hdr or .exr file, studio, none, or empty for the scene's default. You can also drop a file on the window.");
  for (const char* name : {"studio", "none"}) {
    ImGui::SameLine();
    if (ImGui::Button(name)) send(view::UseEnvironment{memory.environment = name});
  }
}

// --- reported values -------------------------------------------------------------------------------------------------

std::string text(glm::vec3 v) {
  return fmt::format("{:.4g} {:.4g} {:.4g}", v.x, v.y, v.z);
}

void pair(const char* name, const std::string& value) {
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(ImGui::GetFontSize() * 6);
  line(value);
}

void drawSurface(const render::Picked& surface) {
  if (surface.id == 0) return line("background");
  pair("node", printable(surface.node));
  pair("mesh", printable(surface.mesh) + fmt::format(", primitive {}", surface.primitive));
  pair("material", printable(surface.material));
  pair("id, part", fmt::format("{}, {}", surface.id, surface.part));
  pair("position", text(surface.position));
  pair("normal", text(surface.normal));
  pair("geonormal", text(surface.geonormal));
  pair("depth", fmt::format("{:.5g} m, distance {:.5g} m", surface.depth, surface.distance));
  pair("uv", fmt::format("{:.4g} {:.4g}", surface.uv.x, surface.uv.y));
}

void drawValues(const view::State& state) {
  if (!state.probe) return line("Rest the pointer on the image, or press P.");
  const view::Probe& probe = *state.probe;
  pair("pixel", fmt::format("{},{}", probe.x, probe.y));
  pair("RGBA", fmt::format("{} {} {} {}", probe.rgba[0], probe.rgba[1], probe.rgba[2], probe.rgba[3]));
  drawSurface(probe.surface);
}

void plot(const std::string& name, const std::deque<float>& values, const char* title, ImVec2 size) {
  const std::vector<float> all(values.begin(), values.end());
  ImGui::PlotLines(("##" + name).c_str(), all.data(), static_cast<int>(all.size()), 0, title, 0, FLT_MAX, size);
}

void drawCosts(const view::State& state, const view::SessionFrame& frame, const PanelMemory& memory) {
  line(fmt::format("G-buffer: {} bytes per pixel, {:.1f} MiB", state.bytesPerPixel,
                   1.0 * state.bytesPerPixel * state.width * state.height / (1 << 20)));
  line(fmt::format("{} x {}, {:.1f} ms{}", frame.width, frame.height, frame.milliseconds,
                   frame.final ? "" : ", a draft"));
  const float letter = ImGui::GetFontSize();
  plot("pictures", memory.times.pictures, "ms per image", {ImGui::GetContentRegionAvail().x, letter * 4});
  for (const graph::PassTime& pass : frame.passes) {
    const auto known = memory.times.passes.find(pass.name);
    plot(pass.name, known == memory.times.passes.end() ? std::deque<float>{} : known->second, nullptr, {letter * 8, 0});
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    line(fmt::format("{:.4g} ms", pass.milliseconds));
    ImGui::SameLine(letter * 14);
    line(pass.name);
  }
}

void drawFiles(const view::State& state, PanelMemory& memory, const Send& send) {
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 7);
  editText("##file", memory.file);
  ImGui::SameLine();
  if (ImGui::Button("screenshot")) send(view::Screenshot{memory.file, memory.side});
  explain("Ctrl+S: writes the image that the command line writes");
  if (ImGui::Button("copy as command (Ctrl+C)")) memory.copies = true;
  ImGui::SameLine();
  if (ImGui::Button("reload")) send(view::Reload{});
  explain("Ctrl+R. Scene files are also reloaded when they change.");
  ImGui::TextWrapped("%s", printable(commandOf(state, memory)).c_str());
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 7);
  if (editText("scene", memory.scene)) send(view::OpenScene{memory.scene});
  explain(
      "Open another scene with Enter: a .gltf, .glb, .obj, .ply or .stl file, or a built-in scene. You can also drop a "
      "file on the window.");
}

}  // namespace

void TimeHistory::add(const view::SessionFrame& frame) {
  constexpr size_t kMax = 120;
  const auto append = [](std::deque<float>& values, double milliseconds) {
    values.push_back(static_cast<float>(milliseconds));
    if (values.size() > kMax) values.pop_front();
  };
  if (frame.milliseconds == last) return;  // the same measurement: only the split was composed again
  last = frame.milliseconds;
  append(pictures, frame.milliseconds);
  for (const graph::PassTime& pass : frame.passes) append(passes[pass.name], pass.milliseconds);
}

const std::string& commandOf(const view::State& state, const PanelMemory& memory) {
  return memory.side == Side::Left ? state.command : state.rightCommand;
}

void drawPanel(const view::State& state, const view::SessionFrame& frame, PanelMemory& memory, const Send& send,
               ImVec2 from, ImVec2 size) {
  ImGui::SetNextWindowPos(from);
  ImGui::SetNextWindowSize(size);
  if (std::exchange(memory.focuses, false)) ImGui::SetNextWindowFocus();
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  line(printable(state.scene));
  ImGui::TextDisabled("%s", printable(state.device).c_str());
  if (!state.error.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 0.5f, 0.4f, 1));
    ImGui::TextWrapped("%s", printable(state.error).c_str());
    ImGui::PopStyleColor();
  }
  if (section("Shown", true)) {
    drawSplit(state, memory, send);
    drawOutputs(state, memory.side, send);
    drawCameras(state, send);
    if (!state.variants.empty()) drawVariants(state, send);
  }
  if (!state.animations.empty() && section("Time", true)) drawTime(state, send);
  if (section("Under the pointer", true)) drawValues(state);
  if (state.selected && section("Selected", true)) drawSurface(*state.selected);
  if (section("Cost", true)) drawCosts(state, frame, memory);
  if (section("Files", true)) drawFiles(state, memory, send);
  drawOptions(state.choices[static_cast<int>(memory.side)], [&](const std::string& name, const std::string& value) {
    send(view::SetOption{name, value, memory.side});
  });
  if (section("Environment image", false)) drawEnvironment(memory, send);
  if (section("Lights", false)) drawLights(state, memory, send);
  ImGui::End();
}

void drawHelp(PanelMemory& memory) {
  if (!memory.help) return;
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin("Keys and mouse (F1)", &memory.help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoFocusOnAppearing);
  for (const auto& [keys, what] : kHelp) {
    line(keys);
    ImGui::SameLine(ImGui::GetFontSize() * 15);
    line(what);
  }
  ImGui::End();
}

}  // namespace latelight::app
