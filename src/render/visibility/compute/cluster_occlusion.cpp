#include "render/visibility/compute/cluster_occlusion.h"

#include <bit>
#include <optional>

namespace latelight::render {

namespace {

// With fewer clusters, the culling passes take longer than the rasterization that they can save.
uint64_t minClusters(const vk::Device& device) {
  return device.isCpu() ? 1u << 12 : 1u << 16;
}

bool mayCull(const vk::Device& device, uint64_t clusters) {
  constexpr uint64_t kMax = 1u << 29;  // 64 MiB of bits
  return clusters >= minClusters(device) && clusters <= kMax;
}

}  // namespace

bool ClusterOcclusion::wouldCull(const vk::Device& device, OcclusionHistory of, uint64_t clusters) const {
  constexpr uint32_t kFinding = 3;  // frames that always cull, since the first has no history,
  constexpr uint32_t kEvery = 64;   // out of this many
  if (!mayCull(device, clusters)) return false;
  const Kept& kept = kept_[static_cast<size_t>(of)];
  return kept.frames % kEvery < kFinding || kept.counts.occluded >= minClusters(device);
}

bool ClusterOcclusion::shouldCull(const vk::Device& device, OcclusionHistory of, uint64_t clusters) {
  const bool culls = wouldCull(device, of, clusters);
  if (!mayCull(device, clusters)) return false;
  ++kept_[static_cast<size_t>(of)].frames;
  decisions_.push_back({of, clusters, culls, nullptr});
  return culls;
}

bool ClusterOcclusion::repeats(const vk::Device& device, const Decision& decision) const {
  const Kept& kept = kept_[static_cast<size_t>(decision.of)];
  if (wouldCull(device, decision.of, decision.clusters) != decision.culls) return false;
  return !decision.buffer || (decision.buffer == kept.buffer && decision.filled == kept.filled);
}

graph::BufferId ClusterOcclusion::addTo(const FrameContext& f, OcclusionHistory of, uint64_t words) {
  Kept& kept = kept_[static_cast<size_t>(of)];
  const uint64_t bytes = sizeof(uint32_t) * std::bit_ceil(words);
  if (!kept.buffer || kept.buffer->desc().size != bytes)
    kept = {std::make_shared<vk::Buffer>(f.device, vk::BufferDesc{.size = bytes, .name = "hidden clusters"})};
  if (!decisions_.empty()) {
    decisions_.back().buffer = kept.buffer;
    decisions_.back().filled = kept.filled;
  }
  const graph::BufferId buffer =
      f.graph.import(*kept.buffer, kept.filled ? std::optional(graph::Use::StorageReadWrite) : std::nullopt);
  if (!kept.filled) addClear(f, graph::Stage::Visibility, "hidden clusters clear", {buffer});
  f.graph.exports(buffer, graph::Use::StorageReadWrite);
  // Other graphs also clear the buffer until a graph that does so has run.
  if (f.overflow)
    f.overflow->checks.push_back([&kept, used = kept.buffer](const graph::Submission&) {
      if (kept.buffer == used) kept.filled = true;
      return false;
    });
  return buffer;
}

}  // namespace latelight::render
