// Origins near a point, relative to which floats are precise.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

namespace latelight::scene {

// Returns one coordinate of the origin. Coordinates near 0 keep it. Others are rounded to a multiple of kOriginStep, so
// that the origin does not change while objects move a little. Coordinates that are not finite return 0.
inline constexpr double kOriginNear = 1024, kOriginStep = 64;  // meters
inline double originNear(double coordinate) {
  const bool isFar = std::isfinite(coordinate) && std::abs(coordinate) >= kOriginNear;
  return isFar ? std::round(coordinate / kOriginStep) * kOriginStep : 0.0;
}

// Returns an open interval of coordinates that all have this origin, a result of originNear().
struct OriginInterval {
  double low, high;
};
inline OriginInterval coordinatesOf(double origin) {
  if (origin == 0) return {-kOriginNear, kOriginNear};
  const double low = origin - kOriginStep / 2, high = origin + kOriginStep / 2;
  return origin > 0 ? OriginInterval{std::max(low, kOriginNear), high}
                    : OriginInterval{low, std::min(high, -kOriginNear)};
}

inline glm::dvec3 originNear(const glm::dvec3& point) {
  return {originNear(point.x), originNear(point.y), originNear(point.z)};
}

}  // namespace latelight::scene
