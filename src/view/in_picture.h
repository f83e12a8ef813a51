// Where things of a scene are in a picture, and where they go when they are dragged there.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/scene.h"

namespace latelight::view {

// Those that are there and have a place, by their numbers in Scene::lights.
std::vector<uint32_t> placedLights(const scene::Scene& scene);

// The pixel of a place; nothing behind the camera.
std::optional<glm::dvec2> pixelOf(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 world);
// Where a thing goes that is dragged from there to a pixel, at its own depth; nothing behind the camera.
std::optional<glm::dvec3> draggedTo(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 from, glm::dvec2 pixel);

// The scene file's frame and the renderer's world.
glm::dvec3 fromFile(const scene::Scene& scene, glm::dvec3 v);
glm::dvec3 toFile(const scene::Scene& scene, glm::dvec3 v);

// Of the instances with this id, at rest.
scene::Bounds boundsOf(const scene::Scene& scene, uint32_t id);

}  // namespace latelight::view
