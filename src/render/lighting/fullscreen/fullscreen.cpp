// fullscreen: deferred shading in one compute pass, which evaluates every light at every pixel: O(pixels x lights). It
// is the reference against which every other technique is compared.
#include "base/error.h"
#include "render/frame/covered_tiles.h"
#include "render/lighting/lighting_push.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

// lavapipe silently ends a shader's loops after 65535 iterations in total, so the remaining lights would be missing. A
// subgroup needs two iterations for each batch of lights that its lanes load, and one for each light that reaches it.
constexpr uint32_t kMaxOnCpu = 200'000;  // at one sample per pixel

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  const uint32_t most = f.device.isCpu() ? kMaxOnCpu / f.setup.samples : ~0u, lights = f.scene.lightCount();
  if (lights > most)
    badUsage("fullscreen supports at most {} lights on a CPU device, but there are {}: choose tiled or clustered", most,
             lights);
  ComputePass lighting = lightingPass(f, gbuffer, "lighting fullscreen", "fullscreen.comp");
  restrictTo(gbuffer.covered, lighting);
  addCompute(f, std::move(lighting),
             [frame = f.constants, covered = gbuffer.covered, visible = gbuffer.visible](graph::Context& context) {
               return shared::LightingPush{frame, coveredAddress(covered, context), surfacePush(visible, context)};
             });
  return {};
}

}  // namespace

TechniqueInfo technique_fullscreen() {
  return {.description = "deferred: one full-screen pass, all lights at every pixel", .add = add};
}

}  // namespace latelight::render
