// Boxes that may be turned, scaled and sheared.
#pragma once

#include <glm/glm.hpp>

namespace latelight::data {

struct OrientedBox {
  glm::dvec3 centre{0};
  glm::dmat3 half{1};  // columns: from the centre to the middles of three faces
};

OrientedBox transformed(const OrientedBox& box, const glm::dmat4& transform);

// Whether a plane separates them, and leaves at least `gap` between (Gottschalk, Lin and Manocha 1996, "OBBTree"): with
// a gap of 0, exactly whether they share no inner point.
bool areApart(const OrientedBox& a, const OrientedBox& b, double gap);

// The extent along a direction of length 1, to each side of the centre.
double extentAlong(const OrientedBox& box, glm::dvec3 direction);

}  // namespace latelight::data
