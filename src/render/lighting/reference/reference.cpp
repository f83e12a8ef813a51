// reference: path tracing from the visible surfaces, the reference for whole pictures.
#include "render/lighting/reference/paths.h"

#include <algorithm>

#include "render/lighting/lighting_shader.h"
#include "render/lighting/reference/paths_push.h"
#include "render/lighting/technique.h"
#include "shared/rays.h"

namespace latelight::render {

namespace {

constexpr uint32_t kBouncesOfPaths = 16;

// Samples per pass. lavapipe silently ends a shader's loops after 65535 iterations in total, which a few paths may
// reach; drivers of GPUs end passes that take seconds.
uint32_t samplesAtOnce(const FrameContext& f) {
  return f.device.isCpu() ? 1 : 16;
}

void addPaths(const FrameContext& f, const Gbuffer& gbuffer, bool fromLights, uint32_t bounces) {
  const uint32_t all = f.setup.paths, atOnce = samplesAtOnce(f);
  const graph::ImageId sum = createTarget(f, VK_FORMAT_R32G32B32A32_SFLOAT, "sum of paths");
  for (uint32_t first = 0; first < all; first += atOnce) {
    const bool kept = first > 0 || !fromLights;
    ComputePass pass = lightingPass(f, gbuffer, "paths", "paths.comp", {.picture = kept, .counts = kept});
    pass.bindings.outside(f.environment.radiance());
    pass.bindings.storage(sum, first > 0 ? graph::Use::StorageReadWrite : graph::Use::StorageWrite);
    pass.constants.push_back({kPathsFromLightsConstant, fromLights ? 1u : 0u});
    pass.fullImage = false;
    const shared::PathsPush push{.frame = f.constants,
                                 .shown = {},
                                 .first = first,
                                 .end = std::min(first + atOnce, all),
                                 .samples = all,
                                 .bounces = bounces};
    addCompute(f, std::move(pass), [push, visible = gbuffer.visible](graph::Context& context) {
      shared::PathsPush filled = push;
      filled.shown = surfacePush(visible, context);
      return filled;
    });
  }
}

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  addPaths(f, gbuffer, true, kBouncesOfPaths);
  return {};
}

}  // namespace

void addIndirect(const FrameContext& f, const Gbuffer& gbuffer) {
  addPaths(f, gbuffer, false, f.setup.indirect == shared::kIndirectPath ? kBouncesOfPaths : 1);
}

TechniqueInfo technique_reference() {
  return {.description = "path tracing over surfaces, lights and the environment: --samples paths per pixel",
          .traces = true,
          .add = add};
}

}  // namespace latelight::render
