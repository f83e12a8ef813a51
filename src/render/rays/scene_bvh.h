// The scene's BVHs in device memory: one per mesh that is visible anywhere, and one over the instances, or one over the
// instances of each world (worlds/). They exist only after the first request for rays.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "render/rays/build/device_bvh_builder.h"
#include "render/rays/bvh.h"
#include "render/rays/worlds/world_bvh.h"
#include "render/rays/worlds/world_mesh_bvh.h"
#include "vk/object_cache.h"

namespace latelight::render {

struct BvhStatistics {
  uint64_t triangles = 0;    // of all meshes that are visible anywhere
  uint64_t bytes = 0;        // device memory
  double buildSeconds = 0;   // until the BVHs were built, since the first request for rays
  double deviceSeconds = 0;  // of these, the time in which the device built meshes; 0: the host built them
};

// sahCost() of the meshes' BVHs, averaged with the numbers of triangles as weights.
struct BvhCosts {
  double inUse = 0;
  double onHost = 0;  // of those that the host builds
};

class SceneBvh {
 public:
  // All must outlive this object. A GPU builds the BVHs of meshes itself; for a CPU device the host does so.
  SceneBvh(vk::Device& device, graph::Executor& executor, const scene::Scene& scene, GpuScene& gpuScene);

  // Sets RayScene::environment, from the next update() on.
  void setEnvironment(VkDeviceAddress cells) { environment_ = cells; }
  // Follows the edits, poses and worlds that GpuScene has followed. Meshes that changed are built again; the next graph
  // refits deformed ones, and builds the instance level of worlds. The uploads are part of GpuScene::uploads().
  void update();
  // The same for worlds that shaders place, and that differ from those of the last update() in arrays only.
  void repeatWorlds() {
    worldMeshes_.repeat();
    worlds_.repeat();
  }
  // Adds the pending work to the prologue of a graph, after the changes of GpuScene and of WorldPlacer. It stays
  // pending until changesSubmitted().
  void addChanges(graph::Graph& graph) const;
  void changesSubmitted();
  // Drops the pending work of a call that failed. The next update() prepares again what it needs of it.
  void discardChanges();

  VkDeviceAddress address(uint32_t world = 0) const;  // shared::RayScene of a world, or of the scene without worlds
  uint32_t emitterCount() const;                      // RayScene::emitterCount; with worlds, the maximum of all
  uint64_t bytes() const;                             // device memory of all BVHs
  BvhStatistics statistics() const;
  // Reads all BVHs back and builds them on the host, which may require seconds.
  BvhCosts costs() const;
  // Reads the BVH of a mesh back from the device. It is empty if the mesh has none.
  Bvh readMesh(uint32_t mesh) const;
  Bvh readWorld(uint32_t world) const { return worlds_.read(world); }  // items are indices of instances

 private:
  struct MeshBvh : DeviceBvh {  // bounds: at rest, in the mesh's space on the device
    uint64_t revision = 0;      // of GpuGeometry, when it was built or refitted
    bool refitted = false;      // its boxes are those of a pose
  };

  void followMeshes();
  void buildMeshes(std::span<const uint32_t> meshes);
  void buildOnHost(std::span<const uint32_t> meshes);
  DeviceBvh uploaded(const scene::Mesh& mesh, const Bvh& bvh);
  void buildInstances();
  void storeRecord();
  void followWorlds();
  void listWorldEmitters();
  bool isShown(uint32_t instance) const;
  Box boundsOf(uint32_t instance) const;
  shared::RayInstance recordOf(uint32_t instance) const;
  void recordRefits(graph::Context& context) const;

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuScene& gpuScene_;
  std::unique_ptr<DeviceBvhBuilder> builder_;  // null: the host builds all BVHs
  std::vector<MeshBvh> meshes_;                // by mesh; without a buffer before it is built
  std::vector<uint32_t> refits_;               // meshes whose refit is pending
  GpuList<shared::RayNode> nodes_;
  GpuList<shared::RayInstance> instances_;
  GpuList<shared::RayScene> record_;
  std::optional<VkDeviceAddress> recordedEnvironment_;  // in record_
  GpuList<shared::RayEmitter> emitters_;
  GpuList<uint32_t> emitterIndices_;
  uint32_t emitterCount_ = 0;
  WorldMeshBvh worldMeshes_;
  WorldBvh worlds_;
  // The instances and triangles that may emit light in any world, if worlds have materials of their own.
  std::vector<bool> emittingInWorlds_;
  GpuList<shared::RayEmitter> worldEmitters_;
  GpuList<uint32_t> worldEmitterIndices_;
  uint32_t worldEmitterCount_ = 0;
  vk::PipelineRef refitPipeline_;
  uint64_t meshBuilds_ = 0;  // increases whenever any of meshes_ is built
  uint64_t meshEdits_ = 0;   // revisions that this follows so far
  uint64_t geometryRevision_ = 0, instanceRevision_ = 0, materialRevision_ = 0;
  VkDeviceAddress environment_ = 0;
  size_t instanceNodes_ = 0, instanceCount_ = 0;
  double buildSeconds_ = 0;
};

}  // namespace latelight::render
