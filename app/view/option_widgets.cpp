#include "app/view/option_widgets.h"

#include <fmt/format.h>
#include <imgui/imgui.h>
#include <imgui/imgui_stdlib.h>

#include <cmath>

#include "app/view/sun.h"
#include "base/text.h"

namespace latelight::app {

namespace {

using render::Option;
using render::OptionKind;

std::string valueOf(const view::Choice& choice, const Option& option) {
  const auto found = choice.options.find(render::keyOf(option));
  return found == choice.options.end() ? option.defaultValue : found->second;
}

// Shows a list of names. Other values can be typed in the field below.
std::optional<std::string> pickName(const Option& option, const std::string& value) {
  std::optional<std::string> picked;
  if (!ImGui::BeginCombo("##value", value.c_str())) return picked;
  for (const render::NamedOption& named : option.names) {
    if (ImGui::Selectable(named.name, value == named.name)) picked = named.name;
    explain(named.description);
  }
  ImGui::EndCombo();
  return picked;
}

// Small ranges use a slider; other numbers are dragged in steps of their own size.
std::optional<std::string> editNumber(const Option& option, const std::string& value) {
  const render::Range& range = option.range;
  const bool whole = option.kind == OptionKind::Integer;
  auto number = static_cast<float>(parseNumber<double>(value).value_or(0));
  const char* format = value.empty() ? "default" : whole ? "%.0f" : "%.4g";
  const bool narrow = std::isfinite(range.least) && std::isfinite(range.most) && range.most - range.least <= 200;
  const auto least = static_cast<float>(std::max(range.least, -1e6)),
             most = static_cast<float>(std::min(range.most, 1e6));
  const float step = whole ? std::max(1.0f, std::abs(number) / 64) : std::max(0.01f, std::abs(number) / 100);
  const bool edited = narrow ? ImGui::SliderFloat("##value", &number, least, most, format)
                             : ImGui::DragFloat("##value", &number, step, least, most, format);
  if (!edited) return std::nullopt;
  if (range.open && number <= range.least) return std::nullopt;
  return whole ? fmt::format("{:.0f}", number) : fmt::format("{:.6g}", number);
}

std::optional<std::string> editSun(const std::string& value) {
  Sun sun = sunOf(value);
  bool on = !value.empty();
  bool edited = ImGui::Checkbox("##on", &on);
  ImGui::BeginDisabled(!on);
  edited |= ImGui::SliderFloat("azimuth", &sun.azimuth, -180, 180, "%.0f");
  edited |= ImGui::SliderFloat("elevation", &sun.elevation, -90, 90, "%.0f");
  edited |= ImGui::DragFloat("lux", &sun.lux, 0.05f, 0, 1e6f, "%.3g");
  ImGui::EndDisabled();
  if (!edited) return std::nullopt;
  return on ? textOf(sun) : "";
}

std::optional<std::string> edit(const Option& option, const std::string& value) {
  switch (option.kind) {
    case OptionKind::Flag: {
      bool on = value == "true";
      return ImGui::Checkbox("##value", &on) ? std::optional<std::string>(on ? "true" : "") : std::nullopt;
    }
    case OptionKind::Choice:
      return pickName(option, value);
    case OptionKind::Integer:
    case OptionKind::Number:
      return editNumber(option, value);
    default:
      break;
  }
  if (render::keyOf(option) == "sun") return editSun(value);
  if (!option.names.empty()) return pickName(option, value);
  std::string text = value;
  return editText("##value", text) ? std::optional(text) : std::nullopt;
}

std::string helpOf(const Option& option) {
  const std::string range = render::rangeText(option);
  const std::string defaultValue = option.defaultValue.empty() ? option.without : option.defaultValue;
  return option.help + (range.empty() ? "" : " (" + range + ")") +
         (defaultValue.empty() ? "" : "\ndefault: " + defaultValue);
}

void drawOption(const view::Choice& choice, const Option& option,
                const std::function<void(const std::string&, const std::string&)>& set) {
  const std::string key(render::keyOf(option));
  const bool changed = choice.options.contains(key);
  ImGui::PushID(key.c_str());
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(changed ? ImVec4(1, 0.75f, 0.35f, 1) : ImGui::GetStyle().Colors[ImGuiCol_Text], "%s", key.c_str());
  explain(helpOf(option));
  ImGui::SameLine(ImGui::GetContentRegionMax().x * 0.45f);
  const float reset = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(changed ? -reset - ImGui::GetStyle().ItemSpacing.x : -1);
  ImGui::BeginGroup();
  ImGui::PushItemWidth(changed ? -reset - ImGui::GetStyle().ItemSpacing.x : -1);
  if (const auto text = edit(option, valueOf(choice, option))) set(key, *text);
  if (ImGui::GetIO().NavVisible) explain(helpOf(option));  // keys cannot reach the name, so the value explains it
  ImGui::PopItemWidth();
  ImGui::EndGroup();
  if (changed) {
    ImGui::SameLine();
    if (ImGui::Button("x", {reset, 0})) set(key, "");
    explain("Back to the default");
  }
  ImGui::PopID();
}

}  // namespace

bool editText(const char* label, std::string& text) {
  return ImGui::InputText(label, &text, ImGuiInputTextFlags_EnterReturnsTrue);
}

void explain(const std::string& text) {
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void drawOptions(const view::Choice& choice, const std::function<void(const std::string&, const std::string&)>& set) {
  std::string group;
  bool open = false;
  for (const Option& option : render::options()) {
    if (render::keyOf(option) == "size") continue;
    if (option.group != group) {
      group = option.group;
      open = ImGui::CollapsingHeader(
          group.c_str(), group == "Picture" || group == "G-buffer and lighting" ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    }
    if (open) drawOption(choice, option, set);
  }
}

}  // namespace latelight::app
