#include "render/shadow/area_shadows.h"

#include <algorithm>

#include "base/error.h"
#include "render/lighting/lighting_shader.h"
#include "render/shadow/area_shadows_push.h"
#include "render/shadow/choose.h"
#include "render/shadow/ray_shadows.h"

namespace latelight::render {

glm::uvec2 areaShadowsOf(const LightSet& lights, const Settings& settings) {
  glm::uvec2 mask{0};
  const ShadowLights& requested = settings.shadowLights;
  const bool none = !requested.automatic && requested.most == 0;
  if (settings.shadows != ShadowFormat::Rays || none) return mask;
  checkShadowLights(requested, lights.authored);  // a scene with area lights alone has no other casters
  for (size_t i = 0; i < std::min<size_t>(lights.area.size(), shared::kMaxAreaLights); ++i) {
    const scene::Light& light = lights.authored[lights.areaSources[i]];
    const bool named = requested.names.empty() || std::ranges::count(requested.names, light.name) > 0;
    if (light.castShadow.value_or(true) && named) mask[static_cast<int>(i / 32)] |= 1u << (i % 32);
  }
  return mask;
}

void addAreaShadows(const FrameContext& f, const Gbuffer& gbuffer) {
  const bool cpu = f.device.isCpu();
  if (cpu && f.setup.areaShadowRays > kMaxRaysOnCpu)
    badUsage("a CPU device supports at most {} shadow rays per light, but --samples requests {}", kMaxRaysOnCpu,
             f.setup.areaShadowRays);
  const uint32_t count = f.scene.areaLights();
  const LightPasses passes = lightPasses(f, count);
  for (uint32_t first = 0; first < count; first += passes.atOnce) {
    ComputePass pass = lightingPass(f, gbuffer, "area shadows", "area_shadows.comp", {.picture = true, .counts = true});
    pass.fullImage = false;
    const shared::AreaShadowsPush push{.frame = f.constants,
                                       .shown = {},
                                       .first = first,
                                       .end = std::min(first + passes.atOnce, count),
                                       .rays = f.setup.areaShadowRays,
                                       .count = count,
                                       .sums = 0};
    useSums(pass, passes, first);
    addCompute(f, std::move(pass), [push, sums = passes.sums, visible = gbuffer.visible](graph::Context& context) {
      shared::AreaShadowsPush filled = push;
      filled.shown = surfacePush(visible, context);
      if (sums) filled.sums = context.buffer(sums).address();
      return filled;
    });
  }
}

}  // namespace latelight::render
