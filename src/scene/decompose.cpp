#include "scene/decompose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace latelight::scene {

namespace {

using glm::dmat4;
using glm::dvec3;

using FlatAxes = std::array<bool, 3>;

// Returns the axes that a scale of 0 makes flat. Their directions are rounding.
FlatAxes findFlat(dvec3 lengths) {
  constexpr double kFlat = 1e-13;  // relative length
  const double largest = std::max({lengths.x, lengths.y, lengths.z});
  return {lengths.x <= kFlat * largest, lengths.y <= kFlat * largest, lengths.z <= kFlat * largest};
}

dvec3 lengthsOf(const glm::dmat3& axes) {
  return {glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])};
}

// The axes of a rotation, of which a scale of zero left those that are flat without a direction. One follows from the
// other two, two are any that are perpendicular to the third, and three are those of the identity.
glm::dmat3 completed(glm::dmat3 axes, FlatAxes isFlat) {
  const auto count = std::ranges::count(isFlat, true);
  if (count == 3) return glm::dmat3(1);
  if (count == 2) {
    const auto known = static_cast<int>(std::ranges::find(isFlat, false) - isFlat.begin());
    const int next = (known + 1) % 3;
    dvec3 other(0);
    other[std::abs(axes[known][next]) < 0.9 ? next : (known + 2) % 3] = 1;
    axes[next] = glm::normalize(other - glm::dot(other, axes[known]) * axes[known]);
    isFlat[static_cast<size_t>(next)] = false;
  }
  for (int i = 0; i < 3; ++i)
    if (isFlat[static_cast<size_t>(i)]) axes[i] = glm::cross(axes[(i + 1) % 3], axes[(i + 2) % 3]);
  return axes;
}

}  // namespace

RigNode decomposeTransform(const dmat4& matrix, dvec3 scaleSigns) {
  const glm::dmat3 axes(matrix);
  dvec3 scale = lengthsOf(axes);
  const FlatAxes isFlat = findFlat(scale);
  if (std::ranges::count(isFlat, true) == 0) {
    const double handedness = glm::determinant(axes);
    if (handedness * scaleSigns.x * scaleSigns.y * scaleSigns.z < 0) scaleSigns = {handedness < 0 ? -1 : 1, 1, 1};
  }
  scale *= scaleSigns;
  glm::dmat3 rotation(1);
  for (int i = 0; i < 3; ++i)
    if (!isFlat[static_cast<size_t>(i)]) rotation[i] = axes[i] / scale[i];
  const glm::dquat q = glm::normalize(glm::quat_cast(completed(rotation, isFlat)));
  return {.matrix = matrix, .translation = dvec3(matrix[3]), .scale = scale, .rotation = {q.x, q.y, q.z, q.w}};
}

dvec3 signsOf(dvec3 scale) {
  return glm::mix(dvec3(1), dvec3(-1), glm::lessThan(scale, dvec3(0)));
}

double decompositionError(const RigNode& node) {
  const dmat4 composed = composeTransform(node.translation, node.rotation, node.scale);
  double error = 0, largest = 0;
  for (int i = 0; i < 12; ++i) {
    error = std::max(error, std::abs(composed[i / 4][i % 4] - node.matrix[i / 4][i % 4]));
    largest = std::max(largest, std::abs(node.matrix[i / 4][i % 4]));
  }
  return largest > 0 ? error / largest : 0;
}

RigNode nodeWithTransform(const dmat4& matrix, dvec3 scaleSigns) {
  const bool isFlat = std::ranges::count(findFlat(lengthsOf(glm::dmat3(matrix))), true) > 0;
  const bool isEnough = !isFlat && scaleSigns.y > 0 && scaleSigns.z > 0;  // a matrix mirrors X
  RigNode node = isEnough ? RigNode{.matrix = matrix} : decomposeTransform(matrix, scaleSigns);
  node.hasMatrix = isEnough || !(decompositionError(node) <= kRoundingOfDoubles);
  return node;
}

}  // namespace latelight::scene
