#include "data/variations/oriented_box.h"

#include <cmath>
#include <initializer_list>

namespace latelight::data {

using glm::dmat3, glm::dmat4, glm::dvec3;

OrientedBox transformed(const OrientedBox& box, const dmat4& transform) {
  return {dvec3(transform * glm::dvec4(box.center, 1)), dmat3(transform) * box.half};
}

double extentAlong(const OrientedBox& box, dvec3 direction) {
  return std::abs(glm::dot(box.half[0], direction)) + std::abs(glm::dot(box.half[1], direction)) +
         std::abs(glm::dot(box.half[2], direction));
}

bool areApart(const OrientedBox& a, const OrientedBox& b, double gap) {
  const auto separates = [&](dvec3 axis) {
    const double length = glm::length(axis);
    if (!(length > 0)) return false;  // edges are parallel; the axes of the face normals suffice
    axis /= length;
    return std::abs(glm::dot(b.center - a.center, axis)) >= extentAlong(a, axis) + extentAlong(b, axis) + gap;
  };
  for (const OrientedBox* box : {&a, &b})
    for (int i = 0; i < 3; ++i)
      if (separates(glm::cross(box->half[(i + 1) % 3], box->half[(i + 2) % 3]))) return true;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (separates(glm::cross(a.half[i], b.half[j]))) return true;
  return false;
}

}  // namespace latelight::data
