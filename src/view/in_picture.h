// Projects positions of a scene into the picture, and drags them back to positions in the scene.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/scene.h"

namespace latelight::view {

// Returns the indices in Scene::lights of the positional lights that are not removed, up to a maximum.
std::vector<uint32_t> positionalLights(const scene::Scene& scene);

// Returns the pixel of a world position, or nothing if it is behind the camera.
std::optional<glm::dvec2> pixelOf(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 world);
// Returns the world position after a drag from `from` to a pixel at constant depth, or nothing if `from` is behind the
// camera.
std::optional<glm::dvec3> draggedTo(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 from, glm::dvec2 pixel);

// Returns the bounds of the instances with this id, at rest.
scene::Bounds boundsOf(const scene::Scene& scene, uint32_t id);

}  // namespace latelight::view
