// Oriented bounding boxes, which may be rotated, scaled and sheared.
#pragma once

#include <glm/glm.hpp>

namespace latelight::data {

struct OrientedBox {
  glm::dvec3 center{0};
  glm::dmat3 half{1};  // columns: vectors from the center to the centers of three faces
};

OrientedBox transformed(const OrientedBox& box, const glm::dmat4& transform);

// Separating axis test (Gottschalk, Lin and Manocha 1996, "OBBTree"): returns true if a plane separates the boxes with
// a distance of at least `gap` between them. With a gap of 0, it is true exactly if they share no interior point.
bool areApart(const OrientedBox& a, const OrientedBox& b, double gap);

// Returns the half extent along a direction of length 1, from the center to each side.
double extentAlong(const OrientedBox& box, glm::dvec3 direction);

}  // namespace latelight::data
