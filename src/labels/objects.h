// The objects of a frame, each with its oriented bounding box and amodal mask. An object is a node with its own id, or
// a group of nodes with a common id.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <vector>

#include "labels/mask.h"
#include "labels/shape.h"
#include "render/submit/scene_state.h"
#include "scene/scene.h"

namespace latelight::labels {

// The number of pixels at which one object is in front of another, whether or not others are in front of both.
struct Occlusion {
  uint32_t id = 0;  // of the object behind
  uint64_t pixels = 0;
  bool operator==(const Occlusion&) const = default;
};

struct Object {
  uint32_t id = 0;
  // The rigid transform (rotation and translation) from the object's own frame to the frame of the output `position`.
  // The node's scale is part of the box.
  glm::dmat4 toWorld{1};
  glm::dvec3 low{0}, high{0};  // the box in the object's own frame, in meters
  Shape shape;                 // empty unless requested

  // The amodal mask (amodal.h). `pixels` and `full` also include pixels beyond the picture, up to one picture width and
  // height away on each side.
  Mask alone;                       // pixels within the picture
  uint64_t pixels = 0;              // number of pixels
  PixelBox full;                    // bounding box of the pixels
  std::vector<Occlusion> occludes;  // the objects that it is in front of within the picture, sorted by id
};

// Returns the box's corners in the object's own frame; x changes fastest, z slowest.
std::array<glm::dvec3, 8> cornersOf(const Object& object);

// The instances of a scene as one state of it has them: the scene itself in a pose, or one of its worlds.
struct PlacedInstances {
  std::vector<glm::dmat4> toWorld;  // by instance
  std::vector<uint8_t> exists;      // by instance; empty: all exist
  bool has(uint32_t instance) const { return exists.empty() || exists[instance] != 0; }
};
PlacedInstances placedInstances(const scene::Scene& scene, const scene::Pose& pose);
PlacedInstances placedInstances(const scene::Scene& scene, const scene::Pose& pose, const render::WorldStates& worlds,
                                uint32_t world);

// Returns the vertices of the meshes that a world deforms. `worlds` must have the numbers of its deformations.
using MeshVertices = std::map<uint32_t, std::vector<glm::vec3>>;  // in object space, by mesh
MeshVertices deformedVertices(const scene::Scene& scene, const scene::Pose& pose, const render::WorldStates& worlds,
                              uint32_t world);

// Returns the objects of a scene in a pose, with their boxes, sorted by id. If `zUp` is true, positions are in the
// renderer's world, otherwise in the scene file's own frame. Shapes are computed only if `geometry` is not null; it
// caches the geometry hashes of `scene`.
std::vector<Object> objectsOf(const scene::Scene& scene, const scene::Pose& pose, bool zUp,
                              GeometryHashes* geometry = nullptr);
// The same with instances in other places than those of the pose, and other vertices of some meshes. No shapes are
// computed.
std::vector<Object> objectsOf(const scene::Scene& scene, const scene::Pose& pose, bool zUp,
                              const PlacedInstances& placed, const MeshVertices& vertices);

}  // namespace latelight::labels
