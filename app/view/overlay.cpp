#include "app/view/overlay.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"

namespace latelight::app {

namespace {

constexpr float kReach = 8;  // radius around a handle, pixels at scale 1
constexpr double kStep = 8;  // pixels by which an arrow key moves a light; one pixel with Shift
constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 230), kDark = IM_COL32(0, 0, 0, 160),
                kYellow = IM_COL32(255, 220, 90, 255);

ImVec2 placeOf(const PictureArea& area, const std::array<float, 2>& at) {
  return {area.from.x + at[0], area.from.y + at[1]};
}

float sliderAt(const view::State& state, const PictureArea& area) {
  return area.from.x + static_cast<float>(state.split.at) * area.size.x;
}

bool hasSlider(const view::State& state) {
  return state.split.mode == view::SetSplit::Slider;
}

std::optional<uint32_t> lightAt(const view::State& state, const PictureArea& area, ImVec2 at) {
  for (uint32_t i = 0; i < state.lights.size(); ++i) {
    if (!state.lights[i].at) continue;
    const ImVec2 place = placeOf(area, *state.lights[i].at);
    if (std::hypot(place.x - at.x, place.y - at.y) <= kReach * area.scale) return i;
  }
  return std::nullopt;
}

bool isShown(const view::LightState& light, const PictureArea& area) {
  return light.at && (*light.at)[0] >= 0 && (*light.at)[1] >= 0 && (*light.at)[0] < area.size.x &&
         (*light.at)[1] < area.size.y;
}

// Returns the next light with a visible handle, or the previous one if `back`; nothing if no handle is visible.
std::optional<uint32_t> lightAfter(const view::State& state, const PictureArea& area, std::optional<uint32_t> light,
                                   bool back) {
  const auto count = static_cast<uint32_t>(state.lights.size());
  const uint32_t from = light.value_or(back ? 0 : count - 1);
  for (uint32_t step = 1; step <= count; ++step) {
    const uint32_t next = (from + (back ? count - step : step)) % count;
    if (isShown(state.lights[next], area)) return next;
  }
  return std::nullopt;
}

ImVec2 arrow(const std::string& key) {
  if (key == "ArrowLeft") return {-1, 0};
  if (key == "ArrowRight") return {1, 0};
  if (key == "ArrowUp") return {0, -1};
  if (key == "ArrowDown") return {0, 1};
  return {0, 0};
}

void label(const view::LightState& light, ImVec2 at) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const std::string text = printable(light.name + " (" + light.type + ")");
  list.AddText({at.x + 1, at.y + 1}, kDark, text.c_str());
  list.AddText(at, kYellow, text.c_str());
}

// Draws a light line inside a dark one, so that it is visible on any image.
void drawLine(ImVec2 from, ImVec2 to, float thickness) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddLine(from, to, kDark, 2 * thickness);
  list.AddLine(from, to, kWhite, thickness);
}

void drawSlider(float x, const PictureArea& area) {
  drawLine({x, area.from.y}, {x, area.from.y + area.size.y}, 2 * area.scale);
  const ImVec2 middle{x, area.from.y + area.size.y / 2};
  ImGui::GetBackgroundDrawList()->AddCircleFilled(middle, kReach * area.scale, kWhite);
}

// Draws a crosshair that does not cover its pixel.
void drawCrosshair(ImVec2 at, const PictureArea& area) {
  for (const float sign : {-area.scale, area.scale}) {
    drawLine({at.x + 4 * sign, at.y}, {at.x + 16 * sign, at.y}, 2 * area.scale);
    drawLine({at.x, at.y + 4 * sign}, {at.x, at.y + 16 * sign}, 2 * area.scale);
  }
}

}  // namespace

void Overlay::drawHandles(const view::State& state, const PictureArea& area) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float reach = kReach * area.scale;
  const auto named = [&](uint32_t i, ImVec2 beside) { label(state.lights[i], {beside.x + 2 * reach, beside.y}); };
  for (const view::LightState& light : state.lights) {
    if (!light.at) continue;
    list.AddCircle(placeOf(area, *light.at), reach - area.scale, kDark, 0, 4 * area.scale);
    list.AddCircle(placeOf(area, *light.at), reach - area.scale, kYellow, 0, 2 * area.scale);
  }
  if (chosen_ && *chosen_ < state.lights.size() && state.lights[*chosen_].at) {
    const ImVec2 place = placeOf(area, *state.lights[*chosen_].at);
    list.AddCircleFilled(place, reach / 2, kYellow);
    return named(*chosen_, place);
  }
  const ImVec2 pointer = ImGui::GetIO().MousePos;
  const auto near = lightAt(state, area, pointer);
  if (near && !ImGui::GetIO().WantCaptureMouse) named(*near, pointer);
}

void Overlay::draw(const view::State& state, const PictureArea& area, bool handles) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.PushClipRect(area.from, {area.from.x + area.size.x, area.from.y + area.size.y});
  if (hasSlider(state)) drawSlider(sliderAt(state, area), area);
  if (handles) drawHandles(state, area);
  if (state.crosshair) drawCrosshair(placeOf(area, {(*state.crosshair)[0] + 0.5f, (*state.crosshair)[1] + 0.5f}), area);
  list.PopClipRect();
}

bool Overlay::press(const view::State& state, const PictureArea& area, ImVec2 at, bool handles) {
  if (hasSlider(state) && std::abs(at.x - sliderAt(state, area)) <= kReach * area.scale)
    held_ = Held::Slider;
  else if (const auto light = handles ? lightAt(state, area, at) : std::nullopt)
    held_ = Held::Light, light_ = *light;
  return held_ != Held::Nothing;
}

bool Overlay::move(const view::State& state, const PictureArea& area, ImVec2 at, const Send& send) const {
  const ImVec2 inside = area.inside(at);
  if (held_ == Held::Slider) {
    view::SetSplit split = state.split;
    split.at = std::clamp(inside.x / std::max(area.size.x, 1.0f), 0.0f, 1.0f);
    send(split);
  } else if (held_ == Held::Light) {
    send(view::DragLight{light_, inside.x, inside.y});
  }
  return held_ != Held::Nothing;
}

bool Overlay::key(const view::State& state, const PictureArea& area, const std::string& name, bool shift,
                  const Send& send) {
  if (name == "Tab") return chosen_ = lightAfter(state, area, chosen_, shift), true;
  if (!chosen_ || *chosen_ >= state.lights.size()) return false;
  if (name == "Escape") return chosen_.reset(), true;
  const ImVec2 way = arrow(name);
  if (way.x == 0 && way.y == 0) return false;
  const double step = shift ? 1 : kStep;
  send(view::NudgeLight{*chosen_, step * way.x, step * way.y});
  return true;
}

bool Overlay::release() {
  return std::exchange(held_, Held::Nothing) != Held::Nothing;
}

}  // namespace latelight::app
