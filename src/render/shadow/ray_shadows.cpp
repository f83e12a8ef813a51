#include "render/shadow/ray_shadows.h"

#include <algorithm>

#include "base/error.h"
#include "render/base/pixel_span.h"
#include "render/lighting/lighting_shader.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/ray_shadows_push.h"

namespace latelight::render {

LightPasses lightPasses(const FrameContext& f, uint32_t lights) {
  LightPasses passes{.atOnce = f.device.isCpu() ? 1 : lights, .sums = {}};
  if (passes.atOnce >= lights) return passes;
  const uint64_t pixels = uint64_t{f.width} * f.height * f.viewCount();
  passes.sums = f.graph.create(vk::BufferDesc{.size = pixels * sizeof(glm::vec3), .name = "sum of lights"});
  return passes;
}

void useSums(ComputePass& pass, const LightPasses& passes, uint32_t first) {
  if (!passes.sums) return;
  pass.buffers.emplace_back(passes.sums, first == 0 ? graph::Use::StorageWrite : graph::Use::StorageReadWrite);
}

void addRayShadows(const FrameContext& f, const Gbuffer& gbuffer) {
  const bool cpu = f.device.isCpu();
  if (cpu && f.shadows->mostRays() > kMaxRaysOnCpu)
    badUsage("a CPU device supports at most {} shadow rays per light, but --samples requests {}", kMaxRaysOnCpu,
             f.shadows->mostRays());
  const uint32_t columns = f.shadows->columns();
  const LightPasses passes = lightPasses(f, columns);
  for (uint32_t first = 0; first < columns; first += passes.atOnce) {
    ComputePass pass = lightingPass(f, gbuffer, "ray shadows", "ray_shadows.comp", {.picture = true, .counts = true});
    pass.fullImage = false;
    // A GPU hides the loads behind other rays, a CPU does not.
    pass.constants.push_back({kReadsSurfaceAgainConstant, cpu ? 0u : 1u});
    useSpans(pass, columns == 1 ? spanSide(f.device, pass.size) : 1);
    const shared::RayShadowsPush push{.frame = f.constants,
                                      .shown = {},
                                      .first = first,
                                      .end = std::min(first + passes.atOnce, columns),
                                      .viewStride = f.shadows->viewStride(),
                                      .count = columns,
                                      .sums = 0};
    useSums(pass, passes, first);
    addCompute(f, std::move(pass), [push, sums = passes.sums, visible = gbuffer.visible](graph::Context& context) {
      shared::RayShadowsPush filled = push;
      filled.shown = surfacePush(visible, context);
      if (sums) filled.sums = context.buffer(sums).address();
      return filled;
    });
  }
}

}  // namespace latelight::render
