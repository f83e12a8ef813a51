#include "render/base/pixel_span.h"

#include "render/base/pixel_group.h"

namespace latelight::render {

namespace {

uint32_t countAlong(uint32_t pixels, uint32_t span) {
  return (pixels + span - 1) / span;
}

// Spans of half a view or more take similar times. Those of smaller parts do not, and a GPU would wait for the longest
// ones. An H200 has 500 to 800 workgroups of these passes in flight, and renders 2048 views at once.
bool suits(uint32_t spansPerView, uint32_t views) {
  constexpr uint32_t kMaxPerView = 2, kMin = 4096;
  return spansPerView <= kMaxPerView && spansPerView * views >= kMin;
}

}  // namespace

uint32_t spanSide(const vk::Device& device, const glm::uvec3& pixels) {
  constexpr uint32_t kBlock = shared::kPixelGroupX * shared::kPixelGroupY;
  // Shaders list pixels in full subgroups.
  if (device.hasCpuShaders() || kBlock % device.subgroupSize() != 0) return 1;
  if (device.isCpu()) return kSpanSide;  // for tests, whose images are small
  const uint32_t spans =
      countAlong(pixels.x, kSpanSide * shared::kPixelGroupX) * countAlong(pixels.y, kSpanSide * shared::kPixelGroupY);
  return suits(spans, pixels.z) ? kSpanSide : 1;
}

void useSpans(ComputePass& pass, uint32_t side) {
  pass.constants.push_back({kSpanConstant, side});
  pass.groupX = side * shared::kPixelGroupX;
  pass.groupY = side * shared::kPixelGroupY;
}

}  // namespace latelight::render
