// The instance level of the BVHs in each world of a call, which shaders build from the instances of the worlds. All
// worlds share the BVHs of meshes, which contain almost all triangles and nodes.
//
//   Instance[worlds][instances]                   (GpuWorlds, or WorldPlacer on the device)
//     | world_instances.comp                      one workgroup per world
//   RayNode[], RayInstance[], RayScene per world
//     | world_emitters.comp                       if worlds differ in their emissive surfaces
//   RayEmitter[] and their indices per world
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "render/rays/bvh.h"
#include "render/rays/worlds/world_bvh_push.h"
#include "vk/object_cache.h"

namespace latelight::render {

// Returns why the device does not support rays in worlds of a scene with this number of instances, as a sentence
// without its period; empty if it does.
std::string missingForRaysInWorlds(const vk::Device& device, uint64_t instances);

class WorldBvh {
 public:
  explicit WorldBvh(vk::Device& device);

  // Prepares the build for the worlds of `scene`, which stays pending until the next graph. `common`: the values that
  // all worlds share; its emitters are those that may emit light in any world. Throws Error(Usage) if the device does
  // not support it.
  void update(const GpuScene& scene, std::vector<shared::MeshHierarchy> meshes, const shared::RayScene& common,
              vk::Uploader& uploader);
  // The same for worlds that the last update() prepared for, with other instances in the same memory.
  void repeat() { pending_ = true; }
  // Adds the pending build to the prologue of a graph, after what writes instances and the BVHs of meshes.
  void addTo(graph::Graph& graph) const;
  void submitted() { pending_ = false; }
  void discard() { pending_ = false; }  // after a call that failed

  VkDeviceAddress address() const { return scenes_.address(); }  // shared::RayScene[worlds]
  uint64_t bytes() const;                                        // device memory
  // Reads the BVH of a world back from the device. Its items are indices of the scene's instances.
  Bvh read(uint32_t world) const;

 private:
  vk::Device& device_;
  struct Pipelines {
    vk::PipelineRef instances, emitters;
  };
  std::optional<Pipelines> pipelines_;  // none before the first call
  shared::WorldBvhJob job_{};
  bool pending_ = false;
  std::vector<shared::MeshHierarchy> meshValues_;  // the last ones that were uploaded
  GpuList<shared::MeshHierarchy> meshes_;
  GpuList<uint64_t> keys_;
  GpuList<shared::ItemBox> boxes_;
  GpuList<shared::RayNode> nodes_;
  GpuList<shared::RayInstance> instances_;
  GpuList<shared::RayScene> scenes_;
  GpuList<shared::RayEmitter> emitters_;
  GpuList<uint32_t> emitterIndices_;
};

}  // namespace latelight::render
