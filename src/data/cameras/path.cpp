#include "data/cameras/path.h"

#include <cmath>

#include "scene/exact_math.h"

namespace latelight::data {

using glm::dvec3, glm::dvec4;

namespace {

dvec4 product(dvec4 a, dvec4 b) {
  const dvec3 u(a[1], a[2], a[3]), v(b[1], b[2], b[3]);
  return dvec4(a[0] * b[0] - glm::dot(u, v), a[0] * v + b[0] * u + glm::cross(u, v));
}
dvec4 conjugate(dvec4 q) {
  return {q[0], -q[1], -q[2], -q[3]};
}

// Returns the quaternion's axis times half its rotation angle.
dvec3 logarithm(dvec4 q) {
  const dvec3 axis(q[1], q[2], q[3]);
  const double sine = glm::length(axis);
  return sine > 0 ? axis * (exact::turnsOf(sine, q[0]) * exact::kTau / sine) : dvec3(0);
}
dvec4 exponential(dvec3 turn) {
  const double angle = glm::length(turn);
  if (angle == 0) return {1, 0, 0, 0};
  return dvec4(exact::cosine(angle), turn * (exact::sine(angle) / angle));
}

}  // namespace

dvec3 catmullRom(const std::array<dvec3, 4>& p, double share) {
  double knots[4] = {0};
  for (size_t i = 0; i < 3; ++i) knots[i + 1] = knots[i] + std::sqrt(glm::length(p[i + 1] - p[i]));
  const double t = knots[1] + (knots[2] - knots[1]) * share;
  // Interpolates between the values at two knots. Equal knots have equal points.
  const auto between = [&](dvec3 a, dvec3 b, double first, double last) {
    return last > first ? (a * (last - t) + b * (t - first)) / (last - first) : b;
  };
  const dvec3 a = between(p[0], p[1], knots[0], knots[1]), b = between(p[1], p[2], knots[1], knots[2]),
              c = between(p[2], p[3], knots[2], knots[3]);
  return between(between(a, b, knots[0], knots[2]), between(b, c, knots[1], knots[3]), knots[1], knots[2]);
}

dvec4 slerp(dvec4 a, dvec4 b, double share) {
  return product(a, exponential(logarithm(product(conjugate(a), b)) * share));
}

dvec4 squadControl(dvec4 before, dvec4 at, dvec4 after) {
  const dvec3 turns = logarithm(product(conjugate(at), after)) + logarithm(product(conjugate(at), before));
  return product(at, exponential(turns * -0.25));
}

dvec4 squad(dvec4 a, dvec4 controlA, dvec4 controlB, dvec4 b, double share) {
  return slerp(slerp(a, b, share), slerp(controlA, controlB, share), 2 * share * (1 - share));
}

}  // namespace latelight::data
