#include "render/rays/build/device_bvh_builder.h"

#include <algorithm>
#include <cstddef>
#include <future>
#include <memory>

#include "base/parallel.h"
#include "render/rays/build/bvh_build_push.h"

namespace latelight::render {

namespace {

using shared::BuildMesh;
using shared::BuildNode;
using shared::BuildResult;
using shared::BvhBuild;
using shared::BvhBuildPush;

// Meshes are built together up to this number of triangles, which bounds the memory of a build.
constexpr uint64_t kTrianglesAtOnce = uint64_t{1} << 24;
// The host builds the nodes above clusters of about so many triangles, up to a number of clusters.
constexpr uint32_t kTrianglesPerCluster = 64, kMaxHostClusters = 32768;
constexpr uint64_t kBytesPerTriangle = 104;  // of a build, in addition to the BVH

uint32_t trianglesOf(const scene::Mesh& mesh) {
  return static_cast<uint32_t>(mesh.indices.size() / 3);
}

// Passes of the sort, an even number so that the last one writes the first arrays.
uint32_t sortPasses(uint32_t meshCount) {
  const uint32_t bits = 3 * shared::kCodeAxisBits + shared::ceilLog2(meshCount);
  const uint32_t passes = (bits + shared::kDigitBits - 1) / shared::kDigitBits;
  return passes + passes % 2;
}

// Usually two thirds as many clusters remain after a round.
uint32_t maxRounds(uint32_t count) {
  return std::min(2 * shared::ceilLog2(count) + 16, shared::kMaxRounds);
}

uint32_t groupsFor(uint64_t count, uint32_t perGroup) {
  return static_cast<uint32_t>((count + perGroup - 1) / perGroup);
}

void barrier(const graph::Context& context) {
  vk::recordMemoryBarrier(context.get(), VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

BuildMesh recordOf(const scene::Mesh& mesh, VkDeviceAddress positions, VkDeviceAddress indices, uint32_t first) {
  const glm::vec3 extent = mesh.boundsMax - mesh.boundsMin;
  const float largest = std::max({extent.x, extent.y, extent.z});
  constexpr float kCells = 1u << shared::kCodeAxisBits;
  return {.positions = positions,
          .indices = indices,
          .low = mesh.boundsMin - scene::vertexOrigin(mesh),
          .scale = largest > 0 ? std::min(kCells / largest, 1e30f) : 0.0f,
          .first = first};
}

// The upper part of a mesh's tree.
struct Top {
  Box bounds;
  uint32_t root = 0;             // as shared::BuildCluster::reference
  uint32_t nodes = 0;            // RayNodes of the mesh
  std::vector<BuildNode> added;  // above the clusters
};

// Builds the nodes above the clusters of a mesh, which will start at `first` among the nodes of the build.
Top topOf(std::span<const BuildResult> clusters, uint32_t first) {
  std::vector<Box> boxes;
  uint32_t height = 0;
  for (const BuildResult& result : clusters) {
    boxes.push_back({result.cluster.low, result.cluster.high});
    height = std::max(height, result.cluster.mesh & shared::kHeightMask);
  }
  Top top{.root = clusters.front().cluster.reference, .nodes = std::max(clusters.front().nodes, 1u)};
  for (const Box& box : boxes) top.bounds.add(box);
  if (clusters.size() == 1) return top;
  const Bvh bvh = buildBvh(boxes, 1, shared::kMaxMeshDepth - height);
  top.added.resize(bvh.nodes.size());
  for (size_t i = bvh.nodes.size(); i-- > 0;) {
    const shared::RayNode& from = bvh.nodes[i];
    BuildNode& node = top.added[i] = {.lowA = from.lowA, .highA = from.highA, .lowB = from.lowB, .highB = from.highB};
    float children = 0;
    node.nodes = 1;
    const auto add = [&](uint32_t reference, float area) {
      const bool cluster = (reference & shared::kRayLeaf) != 0;
      const uint32_t item = cluster ? bvh.items[reference & shared::kRayFirstMask] : reference;
      const uint32_t items = (cluster ? clusters[item].items : top.added[item].items) & ~shared::kBecomesLeaf;
      node.items += items;
      node.nodes += cluster ? clusters[item].nodes : top.added[item].nodes;
      children += static_cast<float>(items) * area;
      return cluster ? clusters[item].cluster.reference : first + item;
    };
    node.a = add(from.a, shared::boxArea(from.lowA, from.highA));
    node.b = add(from.b, shared::boxArea(from.lowB, from.highB));
    const float area = shared::boxArea(glm::min(from.lowA, from.lowB), glm::max(from.highA, from.highB));
    if (!shared::becomesLeaf(node.items, area, children)) continue;
    node.items |= shared::kBecomesLeaf;
    node.nodes = 0;
  }
  top.root = first;
  top.nodes = std::max(top.added.front().nodes, 1u);
  return top;
}

// Returns the clusters of each mesh, which are in the order of meshes.
std::vector<std::span<const BuildResult>> byMesh(std::span<const BuildResult> results, size_t meshCount) {
  std::vector<std::span<const BuildResult>> meshes;
  for (size_t first = 0, end = 0; meshes.size() < meshCount; first = end) {
    while (end < results.size() && results[end].cluster.mesh >> shared::kHeightBits == meshes.size()) ++end;
    meshes.push_back(results.subspan(first, end - first));
  }
  return meshes;
}

// Builds the upper parts of all trees of a batch, whose clusters the device has written.
std::vector<Top> topsOf(std::span<const BuildResult> results, uint32_t count, uint32_t meshCount) {
  const std::vector<std::span<const BuildResult>> clusters = byMesh(results, meshCount);
  size_t remaining = 0;
  for (const std::span<const BuildResult>& mesh : clusters) remaining += mesh.size();
  std::vector<uint32_t> firsts;
  uint32_t first = count - static_cast<uint32_t>(remaining);
  for (const std::span<const BuildResult>& mesh : clusters) {
    firsts.push_back(first);
    first += static_cast<uint32_t>(mesh.size()) - 1;
  }
  std::vector<Top> tops(meshCount);
  parallelFor(meshCount, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) tops[i] = topOf(clusters[i], firsts[i]);
  });
  return tops;
}

}  // namespace

// The memory of a build. Arrays whose contents are not needed at the same time share it.
struct DeviceBvhBuilder::Batch {
  Batch(vk::Device& device, uint32_t count, uint32_t meshCount);
  // Allocates `nodes`, and sets its addresses in `build`. Drivers need milliseconds for hundreds of megabytes, during
  // which they accept no submissions, so the device sorts meanwhile.
  void allocateNodes(vk::Device& device);

  vk::Buffer head;     // BvhBuild, then BuildMesh[]
  vk::Buffer results;  // shared::BuildResult[], readable by the host
  vk::Buffer state;
  vk::Buffer others;   // the arrays of the sort; later, the clusters after the first round; at last, places and queues
  vk::Buffer indices;  // items, partners, counters
  vk::Buffer nodes;    // also the clusters before the first round
  BvhBuild build;
};

DeviceBvhBuilder::Batch::Batch(vk::Device& device, uint32_t count, uint32_t meshCount) {
  const auto make = [&device](const char* name, VkDeviceSize bytes, VkBufferUsageFlags usage = 0) {
    return vk::Buffer(device, {.size = bytes, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage, .name = name});
  };
  const uint32_t counters = std::max(shared::kDigits * groupsFor(count, shared::kKeysPerGroup),
                                     2 * groupsFor(count, shared::kMergedPerGroup));
  const VkDeviceSize n = count;
  head = make("BVH build", sizeof(BvhBuild) + meshCount * sizeof(BuildMesh));
  const uint32_t target = std::max(meshCount, std::min(count / kTrianglesPerCluster, kMaxHostClusters));
  results = vk::Buffer(device,
                       {.size = target * sizeof(BuildResult), .kind = vk::MemoryKind::Readback, .name = "BVH results"});
  state = make("BVH state", sizeof(shared::BuildState), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  others = make("BVH clusters", n * shared::kBuildClusterBytes);
  indices = make("BVH items", (2 * n + counters) * sizeof(uint32_t));
  build = {.meshes = head.address() + sizeof(BvhBuild),
           .results = results.address(),
           .state = state.address(),
           .keys = {others.address(), others.address() + 8 * n},
           .items = {indices.address(), others.address() + 16 * n},
           .counters = indices.address() + 8 * n,
           .clusters = {0, others.address()},
           .partners = indices.address() + 4 * n,
           .places = others.address(),
           .queues = {others.address() + 16 * n, others.address() + 20 * n},
           .count = count,
           .meshCount = meshCount,
           .target = target,
           .rounds = maxRounds(count),
           .maxDepth = shared::kMaxMeshDepth};
}

void DeviceBvhBuilder::Batch::allocateNodes(vk::Device& device) {
  nodes = vk::Buffer(device, {.size = build.count * sizeof(BuildNode), .name = "BVH nodes"});
  build.nodes = nodes.address();
  build.clusters[0] = nodes.address() + build.count * (sizeof(BuildNode) - shared::kBuildClusterBytes);
}

namespace {

// Returns the memory of the BVHs. Its size is exact, unless nodes above clusters become leaves.
std::vector<DeviceBvh> allocateBvhs(vk::Device& device, std::span<const BuildResult> results,
                                    const std::vector<const scene::Mesh*>& meshes) {
  const std::vector<std::span<const BuildResult>> clusters = byMesh(results, meshes.size());
  std::vector<DeviceBvh> bvhs(meshes.size());
  for (size_t i = 0; i < meshes.size(); ++i) {
    VkDeviceSize nodes = std::max<size_t>(clusters[i].size() - 1, 1);
    for (const BuildResult& cluster : clusters[i]) nodes += cluster.nodes;
    bvhs[i].buffer = vk::Buffer(
        device, {.size = nodes * sizeof(shared::RayNode) + trianglesOf(*meshes[i]) * sizeof(shared::RayTriangle),
                 .name = meshes[i]->name + ", BVH"});
  }
  return bvhs;
}

}  // namespace

DeviceBvhBuilder::DeviceBvhBuilder(vk::Device& device, graph::Executor& executor, const scene::Scene& scene,
                                   GpuScene& gpuScene)
    : device_(device), executor_(executor), scene_(scene), gpuScene_(gpuScene) {
  const auto pipeline = [&](const char* shader) {
    return device.cache().pipeline(
        vk::ComputeDesc{.shader = shader, .pushBytes = sizeof(BvhBuildPush), .name = shader});
  };
  codes_ = pipeline("bvh_codes.comp");
  digits_ = pipeline("bvh_digits.comp");
  scan_ = pipeline("bvh_scan.comp");
  sort_ = pipeline("bvh_sort.comp");
  leaves_ = pipeline("bvh_leaves.comp");
  neighbors_ = pipeline("bvh_neighbors.comp");
  merge_ = pipeline("bvh_merge.comp");
  roots_ = pipeline("bvh_roots.comp");
  rootPlaces_ = pipeline("bvh_root_places.comp");
  places_ = pipeline("bvh_places.comp");
}

bool DeviceBvhBuilder::supports(const vk::Device& device, uint64_t triangles) {
  return triangles <= shared::kRayFirstMask &&
         triangles * sizeof(shared::BuildNode) <= std::min(device.maxBufferSize(), device.maxAllocationSize()) &&
         triangles * kBytesPerTriangle <= device.info().memory / 4;
}

std::vector<DeviceBvh> DeviceBvhBuilder::build(std::span<const uint32_t> meshes) {
  std::vector<DeviceBvh> built(meshes.size());
  for (size_t first = 0, end = 0; first < meshes.size(); first = end) {
    uint64_t triangles = 0;
    for (; end < meshes.size() && end - first < shared::kMaxMeshesPerBuild; ++end) {
      triangles += trianglesOf(scene_.meshes[meshes[end]]);
      if (end > first && triangles > kTrianglesAtOnce) break;
    }
    buildBatch(meshes.subspan(first, end - first), std::span(built).subspan(first, end - first));
  }
  return built;
}

// The host waits for the numbers of nodes before it allocates the memory of the BVHs, because they have about half as
// many nodes as they could have. The memory of the build is freed by another thread.
void DeviceBvhBuilder::buildBatch(std::span<const uint32_t> meshes, std::span<DeviceBvh> built) {
  if (freeing_.valid()) freeing_.get();
  std::vector<BuildMesh> records;
  std::vector<const scene::Mesh*> sources;
  uint32_t count = 0;
  for (const uint32_t mesh : meshes) {
    sources.push_back(&scene_.meshes[mesh]);
    records.push_back(
        recordOf(*sources.back(), gpuScene_.geometry().restPositions(mesh), gpuScene_.geometry().indices(mesh), count));
    count += trianglesOf(*sources.back());
  }
  auto batch = std::make_unique<Batch>(device_, count, static_cast<uint32_t>(meshes.size()));
  vk::Uploader& uploads = gpuScene_.uploads();
  uploads.upload(batch->head, std::as_bytes(std::span(&batch->build, 1)));
  uploads.upload(batch->head, std::as_bytes(std::span(records)), sizeof(BvhBuild));
  const graph::Submission sorted = submit("BVH keys", [&](graph::Context& context) { sort(context, *batch); });
  batch->allocateNodes(device_);
  finish(sorted);
  uploads.upload(batch->head, std::as_bytes(std::span(&batch->build, 1)));
  finish(submit("BVH nodes", [&](graph::Context& context) { merge(context, *batch); }));
  const std::span<const BuildResult> results(batch->results.as<const BuildResult>(), batch->build.target);
  std::future<std::vector<DeviceBvh>> allocated =
      inBackground([this, results, &sources] { return allocateBvhs(device_, results, sources); });
  const std::vector<Top> tops = topsOf(results, batch->build.count, batch->build.meshCount);
  std::ranges::move(allocated.get(), built.begin());
  for (size_t i = 0; i < meshes.size(); ++i) {
    built[i].nodes = tops[i].nodes;
    built[i].bounds = tops[i].bounds;
    records[i].nodes = built[i].buffer.address();
    records[i].triangles = built[i].triangles();
    records[i].root = tops[i].root;
    if (!tops[i].added.empty())
      uploads.upload(batch->nodes, std::as_bytes(std::span(tops[i].added)), tops[i].root * sizeof(BuildNode));
  }
  uploads.upload(batch->head, std::as_bytes(std::span(records)), sizeof(BvhBuild));
  finish(submit("BVH places", [&](graph::Context& context) { place(context, *batch); }));
  freeing_ = inBackground([batch = std::move(batch)]() mutable { batch.reset(); });
}

// Submits a step after the pending changes of the scene.
graph::Submission DeviceBvhBuilder::submit(const char* name, const graph::Record& record) {
  graph::Graph graph(executor_);
  gpuScene_.addChanges(graph);
  graph.prologue(graph::Stage::Upload, name, record);
  graph::Submission submission = executor_.submit(graph, graph.compile());
  gpuScene_.changesSubmitted();
  return submission;
}

void DeviceBvhBuilder::finish(const graph::Submission& step) {
  step.wait();
  const std::vector<graph::PassTime>& times = step.times();  // the last one is that of the step
  if (!times.empty()) milliseconds_ += times.back().milliseconds;
}

void DeviceBvhBuilder::dispatch(graph::Context& context, const vk::PipelineRef& pipeline, const Batch& batch,
                                uint32_t items, uint32_t perGroup, uint32_t step, uint32_t values) const {
  barrier(context);
  context.commands().bind(pipeline.get(), {}, BvhBuildPush{batch.head.address(), step, values});
  const uint32_t groups = groupsFor(items, perGroup);
  context.commands().dispatch(std::min(groups, shared::kBuildRow), groupsFor(groups, shared::kBuildRow), 1, 1, 1);
}

void DeviceBvhBuilder::dispatchIndirect(graph::Context& context, const vk::PipelineRef& pipeline, const Batch& batch,
                                        uint32_t step, VkDeviceSize groups) const {
  barrier(context);
  context.commands().bind(pipeline.get(), {}, BvhBuildPush{batch.head.address(), step, 0});
  context.commands().dispatchIndirect(batch.state, groups + step * sizeof(glm::uvec3));
}

void DeviceBvhBuilder::sort(graph::Context& context, const Batch& batch) const {
  const uint32_t count = batch.build.count, passes = sortPasses(batch.build.meshCount);
  const uint32_t counters = shared::kDigits * groupsFor(count, shared::kKeysPerGroup);
  dispatch(context, codes_, batch, count, shared::kBuildGroup);
  for (uint32_t pass = 0; pass < passes; ++pass) {
    dispatch(context, digits_, batch, count, shared::kKeysPerGroup, pass);
    dispatch(context, scan_, batch, 1, 1, pass, counters);
    dispatch(context, sort_, batch, count, shared::kKeysPerGroup, pass);
  }
}

void DeviceBvhBuilder::merge(graph::Context& context, const Batch& batch) const {
  dispatch(context, leaves_, batch, batch.build.count, shared::kBuildGroup);
  constexpr VkDeviceSize kGroups = offsetof(shared::BuildState, mergeGroups);
  for (uint32_t round = 0; round < batch.build.rounds; ++round) {
    dispatchIndirect(context, neighbors_, batch, round, kGroups);
    dispatch(context, scan_, batch, 1, 1, round);
    dispatchIndirect(context, merge_, batch, round, kGroups);
  }
  dispatch(context, roots_, batch, batch.build.target, shared::kBuildGroup);
  vk::recordMemoryBarrier(context.get(), VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

void DeviceBvhBuilder::place(graph::Context& context, const Batch& batch) const {
  dispatch(context, rootPlaces_, batch, batch.build.meshCount, shared::kBuildGroup);
  constexpr VkDeviceSize kGroups = offsetof(shared::BuildState, placeGroups);
  for (uint32_t level = 0; level < batch.build.maxDepth; ++level)
    dispatchIndirect(context, places_, batch, level, kGroups);
}

}  // namespace latelight::render
