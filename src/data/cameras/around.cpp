#include "data/cameras/around.h"

#include <cmath>

#include "scene/exact_math.h"

namespace latelight::data {

using glm::dmat4, glm::dvec3, glm::dvec4;

Around around(const SceneAxes& axes, double azimuth, double sineOfElevation) {
  const glm::dvec2 circle = exact::onCircle(azimuth);
  const dvec3 across = axes.front * circle.x + axes.right * circle.y;
  const double cosine = std::sqrt(std::max(0.0, 1 - sineOfElevation * sineOfElevation));
  return {.outwards = across * cosine + axes.up * sineOfElevation,
          .right = axes.right * circle.x - axes.front * circle.y,
          .up = axes.up * cosine - across * sineOfElevation};
}

dmat4 Around::pose(dvec3 center, double distance) const {
  return dmat4(dvec4(right, 0), dvec4(-up, 0), dvec4(-outwards, 0), dvec4(center + outwards * distance, 1));
}

}  // namespace latelight::data
