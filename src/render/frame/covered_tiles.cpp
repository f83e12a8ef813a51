#include "render/frame/covered_tiles.h"

#include <algorithm>
#include <array>

#include "render/base/pixel_group.h"

namespace latelight::render {

namespace {

constexpr uint32_t kInvocations = 128;  // covered_tiles.comp, with a tile per subgroup
constexpr vk::SamplerDesc kClamped{.magnify = VK_FILTER_NEAREST,
                                   .minify = VK_FILTER_NEAREST,
                                   .mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                   .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};

uint32_t countAlong(uint32_t pixels, uint32_t tile) {
  return (pixels + tile - 1) / tile;
}

}  // namespace

graph::BufferId addCoveredTiles(const FrameContext& f, graph::ImageId depth) {
  using namespace shared;  // CoveredTiles, kPixelGroup*
  const uint32_t across = countAlong(f.width, kPixelGroupX), down = countAlong(f.height, kPixelGroupY);
  static_assert(kMaxTiledViews == 1u << (32 - 2 * kTileBits));
  if (!f.device.hasCpuShaders() || across > kTileMask || down > kTileMask || f.viewCount() > kMaxTiledViews) return {};
  const graph::BufferId covered =
      addSmallBuffer(f, graph::Stage::Visibility, "clear covered tiles", coveredTilesBytes(f), {},
                     [](graph::Context&) { return std::array{kNoTiles}; });
  addCompute(f,
             {.stage = graph::Stage::Visibility,
              .name = "covered tiles",
              .shader = "covered_tiles.comp",
              .bindings = Bindings(f.device).sampled(depth, kClamped),
              .size = {across, down, f.viewCount()},
              .buffers = {{covered, graph::Use::StorageReadWrite}},
              .groupX = std::max(1u, kInvocations / f.device.subgroupSize()),
              .groupY = 1},
             [covered](graph::Context& context) { return CoveredTilesPush{context.buffer(covered).address()}; });
  return covered;
}

uint64_t coveredTilesBytes(const FrameContext& f) {
  const uint64_t across = countAlong(f.width, shared::kPixelGroupX), down = countAlong(f.height, shared::kPixelGroupY);
  return shared::kCoveredTilesBytes + sizeof(uint32_t) * across * down * f.viewCount();
}

void restrictTo(graph::BufferId covered, ComputePass& pass) {
  if (!covered) return;
  pass.groups = covered;
  pass.fullImage = false;
  pass.buffers.emplace_back(covered, graph::Use::StorageRead);
  pass.constants.push_back({kCoveredTilesConstant, 1});
}

VkDeviceAddress coveredAddress(graph::BufferId covered, graph::Context& context) {
  return covered ? context.buffer(covered).address() : 0;
}

}  // namespace latelight::render
