// Turntable and fly camera control, in spherical coordinates around the target.
#include "view/camera_control.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace latelight::view {

namespace {

using glm::dvec3;

// Maximum elevation; the up direction is undefined at the poles.
constexpr double kHighest = 0.4995 * std::numbers::pi;

// The direction from the target to the eye, as that of an orbiting camera in scene/framing.h.
struct Direction {
  double azimuth, elevation;
};

Direction directionOf(dvec3 toEye) {
  const dvec3 d = glm::normalize(toEye);
  return {std::atan2(d.x, -d.y), std::asin(std::clamp(d.z, -1.0, 1.0))};
}

dvec3 unitOf(Direction d) {
  return {std::sin(d.azimuth) * std::cos(d.elevation), -std::cos(d.azimuth) * std::cos(d.elevation),
          std::sin(d.elevation)};
}

double clampedElevation(double elevation) {
  return std::clamp(elevation, -kHighest, kHighest);
}

}  // namespace

ViewAxes axesOf(const Viewpoint& view) {
  const dvec3 away = glm::normalize(view.target - view.eye);
  const double azimuth = directionOf(-away).azimuth;
  const dvec3 right(std::cos(azimuth), std::sin(azimuth), 0);
  return {right, away, glm::cross(right, away)};
}

dvec3 rayThrough(const Viewpoint& view, PicturePoint point) {
  const ViewAxes axes = axesOf(view);
  const double height = 2 * std::tan(view.verticalFov / 2);
  return axes.away + axes.right * (point.x * height) - axes.up * (point.y * height);
}

CameraControl::CameraControl(const Viewpoint& view, double size)
    : view_(view), size_(size > 0 ? size : 1), speed_(size_ / 4) {
  const Direction d = directionOf(view.eye - view.target);
  place(d.azimuth, d.elevation, glm::length(view.eye - view.target));
}

void CameraControl::place(double azimuth, double elevation, double distance) {
  view_.eye = view_.target + unitOf({azimuth, clampedElevation(elevation)}) * std::max(distance, least());
}

void CameraControl::orbit(PicturePoint drag) {
  const dvec3 way = view_.eye - view_.target;
  const Direction d = directionOf(way);
  place(d.azimuth - drag.x * std::numbers::pi, d.elevation + drag.y * std::numbers::pi, glm::length(way));
}

void CameraControl::look(PicturePoint drag) {
  const dvec3 way = view_.eye - view_.target;
  const Direction d = directionOf(way);
  const double elevation = clampedElevation(d.elevation + drag.y * view_.verticalFov);
  view_.target = view_.eye - unitOf({d.azimuth - drag.x * view_.verticalFov, elevation}) * glm::length(way);
}

void CameraControl::pan(PicturePoint drag) {
  const double height = 2 * std::tan(view_.verticalFov / 2) * glm::length(view_.target - view_.eye);
  const ViewAxes axes = axesOf(view_);
  const dvec3 shift = (axes.up * drag.y - axes.right * drag.x) * height;
  view_.eye += shift;
  view_.target += shift;
}

void CameraControl::dolly(double steps, dvec3 towards) {
  const double distance = glm::length(view_.target - view_.eye);
  const double times = std::max(std::pow(0.9, steps), least() / distance);
  view_.eye = towards + (view_.eye - towards) * times;
  view_.target = towards + (view_.target - towards) * times;
}

void CameraControl::fly(dvec3 direction, double seconds) {
  const ViewAxes axes = axesOf(view_);
  const dvec3 shift =
      (axes.right * direction.x + axes.away * direction.y + dvec3(0, 0, direction.z)) * (speed_ * seconds);
  view_.eye += shift;
  view_.target += shift;
}

void CameraControl::changeSpeed(double steps) {
  speed_ = std::clamp(speed_ * std::pow(1.2, steps), 1e-6 * size_, 1e3 * size_);
}

void CameraControl::turnTo(double azimuth, double elevation) {
  place(azimuth, elevation, glm::length(view_.eye - view_.target));
}

void CameraControl::frame(dvec3 center, double radius, double aspect) {
  const Direction d = directionOf(view_.eye - view_.target);
  const double half = std::atan(std::tan(view_.verticalFov / 2) * std::min(1.0, aspect));
  view_.target = center;
  place(d.azimuth, d.elevation, std::max(radius, least()) / std::sin(half));
}

}  // namespace latelight::view
