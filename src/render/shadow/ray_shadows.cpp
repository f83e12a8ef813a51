#include "render/shadow/ray_shadows.h"

#include <algorithm>

#include "base/error.h"
#include "render/lighting/lighting_shader.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/ray_shadows_push.h"

namespace latelight::render {

void addRayShadows(const FrameContext& f, const Gbuffer& gbuffer) {
  const bool cpu = f.device.isCpu();
  if (cpu && f.shadows->mostRays() > kMaxRaysOnCpu)
    badUsage("a CPU device supports at most {} shadow rays per light, but --samples requests {}", kMaxRaysOnCpu,
             f.shadows->mostRays());
  // On a CPU device, each light has its own pass, because a shader's loops are limited there, too (ray_shadows.h).
  const uint32_t columns = f.shadows->columns(), atOnce = cpu ? 1 : columns;
  for (uint32_t first = 0; first < columns; first += atOnce) {
    ComputePass pass = lightingPass(f, gbuffer, "ray shadows", "ray_shadows.comp", {.picture = true, .counts = true});
    pass.fullImage = false;
    // A GPU hides the loads behind other rays, a CPU does not.
    pass.constants.push_back({kReadsSurfaceAgainConstant, cpu ? 0u : 1u});
    const shared::RayShadowsPush push{.frame = f.constants,
                                      .shown = {},
                                      .first = first,
                                      .end = std::min(first + atOnce, columns),
                                      .viewStride = f.shadows->viewStride(),
                                      .padding = 0};
    addCompute(f, std::move(pass), [push, visible = gbuffer.visible](graph::Context& context) {
      shared::RayShadowsPush filled = push;
      filled.shown = surfacePush(visible, context);
      return filled;
    });
  }
}

}  // namespace latelight::render
