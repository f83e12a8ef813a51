#include "app/view/sun_dial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/view/sun.h"

namespace latelight::app {

namespace {

constexpr float kRadius = 36, kMargin = 16;  // pixels at scale 1
constexpr float kDegree = 3.14159265f / 180;

ImVec2 middleOf(const PictureArea& area) {
  const float inset = (kRadius + kMargin) * area.scale;
  return {area.from.x + inset, area.from.y + area.size.y - inset};
}

ImVec2 placeOf(const Sun& sun, const PictureArea& area) {
  const float way = kRadius * area.scale * std::clamp((90 - sun.elevation) / 90, 0.0f, 1.0f);
  const ImVec2 middle = middleOf(area);
  return {middle.x + way * std::sin(sun.azimuth * kDegree), middle.y - way * std::cos(sun.azimuth * kDegree)};
}

}  // namespace

void SunDial::draw(const std::string& sun, const PictureArea& area) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float scale = area.scale;
  const ImU32 yellow = IM_COL32(255, 220, 90, sun.empty() ? 120 : 255), white = IM_COL32(255, 255, 255, 160);
  const ImVec2 middle = middleOf(area), place = placeOf(sunOf(sun), area);
  list.AddCircleFilled(middle, (kRadius + 6) * scale, IM_COL32(0, 0, 0, 110));
  list.AddCircle(middle, kRadius * scale, white, 0, scale);
  list.AddCircleFilled(middle, 2 * scale, white);
  list.AddLine(middle, place, yellow, scale);
  list.AddCircleFilled(place, 7 * scale, yellow);
}

bool SunDial::press(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set) {
  const ImVec2 middle = middleOf(area);
  held_ = std::hypot(at.x - middle.x, at.y - middle.y) <= (kRadius + 6) * area.scale;
  return move(sun, area, at, set);
}

// At the center the azimuth is unchanged.
bool SunDial::move(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set) const {
  if (!held_) return false;
  const ImVec2 middle = middleOf(area);
  const float x = at.x - middle.x, y = middle.y - at.y, way = std::hypot(x, y) / (kRadius * area.scale);
  Sun moved = sunOf(sun);
  if (way > 0) moved.azimuth = std::round(std::atan2(x, y) / kDegree);
  moved.elevation = std::round(90 * (1 - std::min(way, 1.0f)));
  set(textOf(moved));
  return true;
}

bool SunDial::release() {
  return std::exchange(held_, false);
}

}  // namespace latelight::app
