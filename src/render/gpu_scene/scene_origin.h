// The origin of world space on the device. Floats relative to it are precise near most of the scene.
#pragma once

#include <glm/vec3.hpp>
#include <span>

namespace latelight::render {

struct WorldSphere;

// Returns the origin for instances with these bounds: on each axis scene::originNear() of the weighted median of the
// centers of all visible instances. A median stays near most instances however far the others are, which a mean does
// not. Large instances have small weights, because the center of a large ground does not tell where on it the scene is.
// The result depends only on the spheres, and not on their order. `previous`: an earlier result, or 0; the call is
// fastest if it is the result again.
glm::dvec3 sceneOrigin(std::span<const WorldSphere> spheres, const glm::dvec3& previous);

}  // namespace latelight::render
