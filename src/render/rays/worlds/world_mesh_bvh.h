// The BVHs of the meshes that worlds deform (WorldDeformer). Each world has nodes of its own, with the boxes of its
// vertices; their topology and the triangles are those of the mesh at rest.
//
//   RayNode[] at rest (SceneBvh) --- copied once ---> RayNode[worlds][nodes] per mesh
//   positions of worlds (WorldDeformer) --- ray_refit.comp, in every call ---^
#pragma once

#include <span>
#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "render/rays/build/device_bvh_builder.h"
#include "render/rays/worlds/world_bvh_push.h"
#include "vk/object_cache.h"

namespace latelight::render {

class WorldMeshBvh {
 public:
  explicit WorldMeshBvh(vk::Device& device);

  // Prepares the refit for the worlds of `scene`, which stays pending until the next graph, and appends the hierarchies
  // to those of the scene's meshes, in the order of GpuGeometry::derive(). `meshes`: the BVHs of all meshes.
  // `builds` differs from earlier calls if any of these was built since.
  void update(const GpuScene& scene, std::span<const DeviceBvh* const> meshes, uint64_t builds,
              std::vector<shared::MeshHierarchy>& hierarchies);
  // The same for worlds that the last update() prepared for, with other vertices in the same memory.
  void repeat() { pending_ = !parts_.empty(); }
  // Adds the pending refit to the prologue of a graph, after what writes the vertices of worlds.
  void addTo(graph::Graph& graph) const;
  void submitted();
  // Drops the pending refit of a call that failed. The copies stay pending, because later refits require them.
  void discard() { pending_ = false; }

  uint64_t bytes() const { return nodes_ ? nodes_.size() : 0; }  // device memory

 private:
  struct Part {  // one mesh
    uint32_t mesh;
    uint32_t nodes;       // 0: rays do not hit it
    VkBuffer rest;        // starts with the nodes at rest
    uint64_t triangles;   // address
    uint64_t offset = 0;  // bytes in nodes_, of the first world
  };
  // The state that the copied nodes depend on.
  struct Copied {
    std::vector<uint32_t> meshes;
    uint32_t worlds = 0;
    uint64_t builds = 0;
    bool operator==(const Copied&) const = default;
  };
  void recordCopies(VkCommandBuffer commands) const;

  vk::Device& device_;
  vk::PipelineRef pipeline_;
  std::vector<Part> parts_;
  vk::Buffer nodes_;
  Copied copied_;
  bool copies_ = false, pending_ = false;  // the copies, and the refit, are pending
  uint32_t worlds_ = 0, firstMesh_ = 0;
  VkDeviceAddress records_ = 0;  // shared::Mesh[]
};

}  // namespace latelight::render
