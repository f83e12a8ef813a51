// Builds the BVHs of many meshes on the device, all of them together in the same dispatches.
//
// Triangles become clusters of one, in the order of the Morton codes of their centers. In each round, clusters that are
// each other's nearest neighbor in that order merge: parallel locally-ordered clustering (Meister and Bittner 2018,
// Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction, IEEE TVCG 24(3)). This finds good
// subtrees, but the boxes of large clusters overlap. So the rounds end at clusters of about 64 triangles, and the host
// builds the nodes above them with the surface area heuristic (bvh.h). At last, nodes and triangles are written where
// rays read them.
//
//   positions, indices of all meshes
//     | bvh_codes                     a key per triangle: mesh, Morton code
//   keys, items
//     | bvh_digits, bvh_scan, bvh_sort: 4 bits of the key per pass
//   keys, items in order
//     | bvh_leaves
//   clusters  <----------------+
//     | bvh_neighbors          |      partners, counters
//     | bvh_scan               |      positions of clusters and nodes after the round
//     | bvh_merge -------------+-->   nodes
//     | bvh_roots                     results: the remaining clusters, for the host
//     | the host                      further nodes; meanwhile, another thread allocates the memory of the BVHs
//   nodes
//     | bvh_root_places, bvh_places   level by level: parents place their children
//   RayNode[] and RayTriangle[] per mesh
//
// No result depends on the order in which invocations run, so a device builds the same bytes each time. The depth and
// the number of rounds are bounded for all boxes (bvh_neighbors.comp).
#pragma once

#include <future>
#include <span>
#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "render/rays/bvh.h"
#include "vk/object_cache.h"

namespace latelight::render {

// A BVH in device memory.
struct DeviceBvh {
  vk::Buffer buffer;  // shared::RayNode[nodes], then shared::RayTriangle[]
  uint32_t nodes = 0;
  Box bounds;

  VkDeviceSize nodeBytes() const { return nodes * sizeof(shared::RayNode); }
  VkDeviceAddress triangles() const { return buffer.address() + nodeBytes(); }
};

class DeviceBvhBuilder {
 public:
  // All must outlive this object.
  DeviceBvhBuilder(vk::Device& device, graph::Executor& executor, const scene::Scene& scene, GpuScene& gpuScene);

  // Returns true if a build of so many triangles fits the device.
  static bool supports(const vk::Device& device, uint64_t triangles);

  // Builds the BVHs of meshes that have triangles, from their vertices at rest. Submits the pending changes of the
  // scene, because meshes may be among them, and waits.
  std::vector<DeviceBvh> build(std::span<const uint32_t> meshes);

  double milliseconds() const { return milliseconds_; }  // of all builds, on the device

 private:
  struct Batch;
  void buildBatch(std::span<const uint32_t> meshes, std::span<DeviceBvh> built);
  void sort(graph::Context& context, const Batch& batch) const;
  void merge(graph::Context& context, const Batch& batch) const;
  void place(graph::Context& context, const Batch& batch) const;
  void dispatch(graph::Context& context, const vk::PipelineRef& pipeline, const Batch& batch, uint32_t items,
                uint32_t perGroup, uint32_t step = 0, uint32_t values = 0) const;
  void dispatchIndirect(graph::Context& context, const vk::PipelineRef& pipeline, const Batch& batch, uint32_t step,
                        VkDeviceSize groups) const;
  graph::Submission submit(const char* name, const graph::Record& record);
  void finish(const graph::Submission& step);  // waits, and adds its time on the device

  vk::Device& device_;
  graph::Executor& executor_;
  const scene::Scene& scene_;
  GpuScene& gpuScene_;
  std::future<void> freeing_;  // of the last build's memory
  vk::PipelineRef codes_, digits_, scan_, sort_, leaves_, neighbors_, merge_, roots_, rootPlaces_, places_;
  double milliseconds_ = 0;
};

}  // namespace latelight::render
