#include "app/view/overlay.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"

namespace latelight::app {

namespace {

constexpr float kReach = 8;  // about a handle, pixels at scale 1
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

}  // namespace

void Overlay::draw(const view::State& state, const PictureArea& area, bool handles) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float reach = kReach * area.scale;
  list.PushClipRect(area.from, {area.from.x + area.size.x, area.from.y + area.size.y});
  if (hasSlider(state)) {
    const float x = sliderAt(state, area), middle = area.from.y + area.size.y / 2;
    list.AddLine({x, area.from.y}, {x, area.from.y + area.size.y}, kDark, 4 * area.scale);
    list.AddLine({x, area.from.y}, {x, area.from.y + area.size.y}, kWhite, 2 * area.scale);
    list.AddCircleFilled({x, middle}, reach, kWhite);
  }
  if (handles)
    for (const view::LightState& light : state.lights) {
      if (!light.at) continue;
      list.AddCircle(placeOf(area, *light.at), reach - area.scale, kDark, 0, 4 * area.scale);
      list.AddCircle(placeOf(area, *light.at), reach - area.scale, kYellow, 0, 2 * area.scale);
    }
  const ImVec2 pointer = ImGui::GetIO().MousePos;
  const auto near = handles ? lightAt(state, area, pointer) : std::nullopt;
  if (near && !ImGui::GetIO().WantCaptureMouse) {
    const std::string label = printable(state.lights[*near].name + " (" + state.lights[*near].type + ")");
    list.AddText({pointer.x + 2 * reach + 1, pointer.y + 1}, kDark, label.c_str());
    list.AddText({pointer.x + 2 * reach, pointer.y}, kYellow, label.c_str());
  }
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

bool Overlay::release() {
  return std::exchange(held_, Held::Nothing) != Held::Nothing;
}

}  // namespace latelight::app
