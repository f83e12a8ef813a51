#include "data/variations/frames.h"

#include "scene/builtin/exact_math.h"

namespace latelight::data {

// Rodrigues' rotation formula, applied to each column.
glm::dmat4 turnAbout(glm::dvec3 axis, double degrees) {
  const double c = scene::builtin::cosQuarters(degrees / 90), s = scene::builtin::sinQuarters(degrees / 90);
  glm::dmat4 turn(1);
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 unit(0);
    unit[i] = 1;
    turn[i] = glm::dvec4(unit * c + glm::cross(axis, unit) * s + axis * (axis[i] * (1 - c)), 0);
  }
  return turn;
}

}  // namespace latelight::data
