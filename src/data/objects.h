// The objects of a frame: nodes with an id of their own, or groups of them, each with the box around it and the pixels
// that it would cover alone.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "data/mask.h"
#include "data/shape.h"
#include "render/moment.h"
#include "scene/scene.h"

namespace latelight::data {

struct Object {
  uint32_t id = 0;
  // The object's own frame to the frame of positions: rotation and translation; the node's scale is in the box.
  glm::dmat4 toWorld{1};
  glm::dvec3 low{0}, high{0};  // the box in the object's own frame, metres
  Shape shape;                 // empty, unless asked for

  // Where it was rendered alone (amodal.h).
  Mask alone;           // pixels of the picture
  uint64_t pixels = 0;  // of those, and of what lies beyond, up to a picture's width and height away on each side
  PixelBox full;        // around all of them
};

// The box's corners in the object's own frame: x changes first, then y, then z.
std::array<glm::dvec3, 8> cornersOf(const Object& object);

// Those of a scene in a pose, with their boxes, sorted by id. `zUp`: positions are in the renderer's world, else in the
// scene file's own frame. `geometry`, of the scene: where their shapes are asked for.
std::vector<Object> objectsOf(const scene::Scene& scene, const scene::Pose& pose, bool zUp,
                              GeometryHashes* geometry = nullptr);

}  // namespace latelight::data
