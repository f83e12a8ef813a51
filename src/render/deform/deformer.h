// Meshes whose vertices move: skins and morph targets, on the device.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/gpu_scene/geometry.h"
#include "scene/animation.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/device.h"
#include "vk/object_cache.h"
#include "vk/resources.h"

namespace latelight::render {

// The current pose, and those of the previous and the next frame. Empty ones are the scene at rest.
struct Poses {
  scene::Pose previous, current, next;
};

class Deformer {
 public:
  // Uploads the scene's deformed meshes before deformation. There must be at least one.
  Deformer(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);

  // Takes joint matrices and weights of all three poses, none of which may be empty.
  void pose(const Poses& poses);
  // Adds the passes that compute all vertices of those poses, to the prologue.
  void addTo(graph::Graph& graph) const;

  // Points the records and streams of deformed meshes to the results.
  void describe(std::span<shared::Mesh> meshes, std::span<VertexStreams> streams) const;

  // Bounds of a deformed mesh in the pose, in its object space.
  scene::ReachBox boundsOf(uint32_t mesh, const scene::Pose& pose) const;
  // True where the pose turns the triangles over that the mesh has at rest.
  bool turnsOver(uint32_t mesh, const scene::Pose& pose) const;

 private:
  struct Part {  // of one mesh
    uint32_t mesh;
    const scene::Deformation* deformation;
    scene::Reach reach;
    uint32_t firstVertex;                   // among the vertices of all parts
    uint64_t joints, jointWeights, deltas;  // byte offsets
  };
  struct Palette {  // joint matrices and weights of all parts and poses
    std::vector<glm::mat4x3> matrices;
    std::vector<float> weights;
    struct Place {                 // of a part
      uint64_t matrices, weights;  // byte offsets
      uint32_t jointCount;
    };
    std::vector<Place> places;
  };
  void upload(vk::Uploader& uploader);
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
