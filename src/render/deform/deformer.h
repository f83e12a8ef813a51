// Deforms meshes by skins and morph targets on the device (deform.comp).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/deform/deform_push.h"
#include "render/gpu_scene/geometry.h"
#include "scene/animation.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/device.h"
#include "vk/object_cache.h"
#include "vk/resources.h"

namespace latelight::render {

// The poses of the current, previous and next frame. If they are empty, the scene is at rest.
struct Poses {
  scene::Pose previous, current, next;
};

class Deformer {
 public:
  // Uploads the undeformed vertices of the scene's deformable meshes. The scene must have at least one.
  Deformer(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);

  // Computes the joint matrices and morph weights of all three poses, none of which may be empty.
  void pose(const Poses& poses);
  // Adds the dispatches that deform all vertices in those poses to the graph's prologue.
  void addTo(graph::Graph& graph) const;

  // Points the records and streams of deformed meshes to the results.
  void describe(std::span<shared::Mesh> meshes, std::span<VertexStreams> streams) const;

  // Returns the bounds of a deformed mesh in the pose, in its object space.
  scene::ReachBox boundsOf(uint32_t mesh, const scene::Pose& pose) const;
  // Returns true if the pose reverses the winding of the mesh's triangles compared with the mesh at rest.
  bool turnsOver(uint32_t mesh, const scene::Pose& pose) const;

  // For dispatches with other poses: the undeformed mesh, without poses and results, its joint matrices and weights in
  // a pose, and its extent.
  shared::DeformPush pushOf(uint32_t mesh) const { return pushOf(parts_[partOf_[mesh]]); }
  std::vector<glm::mat4> joints(uint32_t mesh, const scene::Pose& pose) const;
  std::vector<float> weights(uint32_t mesh, const scene::Pose& pose) const;
  const scene::Reach& reach(uint32_t mesh) const { return parts_[partOf_[mesh]].reach; }
  // Dispatches one shader over all vertices of all worlds, in `poses` poses.
  void dispatch(graph::Context& context, const shared::DeformPush& push, uint32_t poses) const;

 private:
  struct Part {  // one mesh
    uint32_t mesh;
    const scene::Deformation* deformation;
    scene::Reach reach;
    uint32_t firstVertex;                   // index among the vertices of all parts
    uint64_t joints, jointWeights, deltas;  // byte offsets
  };
  struct Palette {  // joint matrices and weights of all parts and poses
    std::vector<glm::mat4x3> matrices;
    std::vector<float> weights;
    struct Place {                 // of one part
      uint64_t matrices, weights;  // byte offsets
      uint32_t jointCount;
    };
    std::vector<Place> places;
  };
  void upload(vk::Uploader& uploader);
  shared::DeformPush pushOf(const Part& part) const;
  void record(graph::Context& context, VkDeviceAddress matrices, VkDeviceAddress weights) const;

  vk::Device& device_;
  const scene::Scene& scene_;
  vk::PipelineRef pipeline_;
  std::vector<Part> parts_;
  std::vector<uint32_t> partOf_;  // by mesh; ~0u: none
  uint32_t vertices_ = 0;
  vk::Buffer basePositions_, baseAttributes_, joints_, jointWeights_, deltas_;
  vk::Buffer positions_, attributes_;  // deformed
  Palette palette_;
};

}  // namespace latelight::render
