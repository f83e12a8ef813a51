// Transforms between the scene file's own frame, in which jobs specify positions, and the renderer's world.
#pragma once

#include "scene/scene.h"

namespace latelight::data {

inline glm::dmat4 worldFromFile(const scene::Scene& scene) {
  return scene.yUp ? glm::dmat4(scene::toWorldFromGltf()) : glm::dmat4(1);
}
inline glm::dmat4 fileFromWorld(const scene::Scene& scene) {
  return glm::transpose(worldFromFile(scene));  // a rotation
}
inline glm::dvec3 upOf(const scene::Scene& scene) {
  return scene.yUp ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
}

// Returns a rotation about an axis of length 1. It rounds identically on every machine.
glm::dmat4 turnAbout(glm::dvec3 axis, double degrees);

}  // namespace latelight::data
