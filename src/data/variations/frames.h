// Directions and rotations in the scene file's own frame, in which jobs specify positions.
#pragma once

#include "scene/scene.h"

namespace latelight::data {

inline glm::dvec3 upOf(const scene::Scene& scene) {
  return scene.yUp ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
}

// Returns a rotation about an axis of length 1. It rounds identically on every machine.
glm::dmat4 turnAbout(glm::dvec3 axis, double degrees);

}  // namespace latelight::data
