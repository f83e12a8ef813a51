// The objects of a scene and their own frames. An object is everything with one id: the primitives of a node, or a
// group of nodes (IdGrouping).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// An axis-aligned box, empty at first.
struct Extent {
  dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  void add(dvec3 point) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  bool empty() const { return low.x > high.x; }
};

// Returns the rotation and translation of an affine transform. Scale, shear and mirroring are dropped: they are part of
// the coordinates in an object's frame. `scaleSigns`: 1 or -1 for each axis, the signs of the scale. If they do not
// agree with the transform, it has no scale below 0, except for that of x if it mirrors.
dmat4 rigidOf(const dmat4& m, dvec3 scaleSigns);

// Returns a node's transform in the world, in a pose. Edits move instances, not their nodes.
dmat4 nodeToWorld(const Scene& scene, const Pose& pose, uint32_t node);

// Returns the world transform that an instance has by its node in a pose, unless an edit has placed it. A skinned
// instance follows its joints only.
dmat4 followedToWorld(const Scene& scene, const Pose& pose, uint32_t instance);

// Returns the transform in the world by which edits or worlds have moved all these instances from their nodes' places.
// Empty if they moved differently, beyond rounding. `toWorld`: of all instances.
std::optional<dmat4> commonDisplacement(const Scene& scene, const Pose& pose, std::span<const dmat4> toWorld,
                                        std::span<const uint32_t> instances);

// The frames of objects. Create one for all objects of a scene, which must not change meanwhile.
class ObjectFrames {
 public:
  explicit ObjectFrames(const Scene& scene);

  // Returns the world transform of the node that an object's instances belong to: of their common node, or for a group
  // of its topmost node, which edits and worlds move if they move all these instances alike. `toWorld`: of all
  // instances. rigidOf() of the result is the object's own frame.
  dmat4 toWorld(const Pose& pose, std::span<const dmat4> toWorld, std::span<const uint32_t> instances) const;

  // Returns the signs of the scales of this node and of those above it, multiplied: with them, the object's own frame
  // has the rotations that the nodes state.
  dvec3 scaleSigns(std::span<const uint32_t> instances) const;

 private:
  bool isGroup(std::span<const uint32_t> instances) const;

  const Scene& scene_;
  std::vector<bool> hasChildInGroup_;  // per node
};

// Returns the signs for an instance's own node and copy, also if it belongs to a group. Joints that move the instance
// are not included, but the copy is.
dvec3 instanceScaleSigns(const Scene& scene, uint32_t instance);
// Return the signs of the scale of a node, and of a copy by EXT_mesh_gpu_instancing relative to its node.
dvec3 nodeScaleSigns(const Scene& scene, uint32_t node);
dvec3 copyScaleSigns(const Scene& scene, uint32_t instance);

// Extends the box by the vertices of a mesh at rest, transformed.
void addMesh(Extent& extent, const Mesh& mesh, const dmat4& transform);

// The place of an instance in its object, with the whole scene at rest.
struct RestFrame {
  dmat4 objectFromMesh{1};  // from the mesh's object space to the object's own frame
  Extent box;               // of the whole object, in its own frame
};
// Returns one per instance. Removed instances have an empty box.
std::vector<RestFrame> restFrames(const Scene& scene);

}  // namespace latelight::scene
