// Transforms between a scene file's own frame, in which users specify positions, and the renderer's world. The file's
// frame is glTF's (Y up, front +Z) if Scene::yUp, otherwise the world's (Z up, front -Y).
#pragma once

#include "scene/scene.h"

namespace latelight::scene {

inline glm::dmat4 worldFromFile(const Scene& scene) {
  return scene.yUp ? toWorldFromGltf() : glm::dmat4(1);
}
inline glm::dmat4 fileFromWorld(const Scene& scene) {
  return scene.yUp ? toGltfFromWorld() : glm::dmat4(1);
}

// The same for a position or direction. Exact for all values, also for the sign of zeros.
inline glm::dvec3 worldFromFile(const Scene& scene, glm::dvec3 v) {
  return scene.yUp ? glm::dvec3(v.x, -v.z, v.y) : v;
}
inline glm::dvec3 fileFromWorld(const Scene& scene, glm::dvec3 v) {
  return scene.yUp ? glm::dvec3(v.x, v.z, -v.y) : v;
}

}  // namespace latelight::scene
