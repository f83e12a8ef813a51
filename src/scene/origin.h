// Origins near a point, relative to which floats are precise.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace latelight::scene {

// Returns one coordinate of the origin. Coordinates near 0 keep it. Others are rounded to a multiple of kStep, so that
// the origin does not change while objects move a little. Coordinates that are not finite return 0.
inline double originNear(double coordinate) {
  constexpr double kNear = 1024, kStep = 64;  // meters
  return std::isfinite(coordinate) && std::abs(coordinate) >= kNear ? std::round(coordinate / kStep) * kStep : 0.0;
}

inline glm::dvec3 originNear(const glm::dvec3& point) {
  return {originNear(point.x), originNear(point.y), originNear(point.z)};
}

}  // namespace latelight::scene
