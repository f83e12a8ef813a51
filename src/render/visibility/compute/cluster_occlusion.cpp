#include "render/visibility/compute/cluster_occlusion.h"

#include <bit>
#include <optional>

namespace latelight::render {

bool ClusterOcclusion::shouldCull(const vk::Device& device, OcclusionHistory of, uint64_t clusters) {
  constexpr uint32_t kFinding = 3;     // frames that always cull, since the first has no history,
  constexpr uint32_t kEvery = 64;      // out of this many
  constexpr uint64_t kMax = 1u << 29;  // 64 MiB of bits
  // With fewer clusters, the culling passes take longer than the rasterization that they can save.
  const uint64_t fewest = device.isCpu() ? 1u << 12 : 1u << 16;
  if (clusters < fewest || clusters > kMax) return false;
  Kept& kept = kept_[static_cast<size_t>(of)];
  const uint32_t frame = kept.frames++ % kEvery;
  return frame < kFinding || kept.counts.occluded >= fewest;
}

graph::BufferId ClusterOcclusion::addTo(const FrameContext& f, OcclusionHistory of, uint64_t words) {
  Kept& kept = kept_[static_cast<size_t>(of)];
  const uint64_t bytes = sizeof(uint32_t) * std::bit_ceil(words);
  if (!kept.buffer || kept.buffer->desc().size != bytes)
    kept = {std::make_shared<vk::Buffer>(f.device, vk::BufferDesc{.size = bytes, .name = "hidden clusters"})};
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
