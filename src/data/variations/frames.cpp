#include "data/variations/frames.h"

#include "scene/exact_math.h"

namespace latelight::data {

// Rodrigues' rotation formula, applied to each column.
glm::dmat4 turnAbout(glm::dvec3 axis, double degrees) {
  const double c = exact::cosQuarters(degrees / 90), s = exact::sinQuarters(degrees / 90);
  glm::dmat4 turn(1);
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 unit(0);
    unit[i] = 1;
    turn[i] = glm::dvec4(unit * c + glm::cross(axis, unit) * s + axis * (axis[i] * (1 - c)), 0);
  }
  return turn;
}

}  // namespace latelight::data
