#include "study/light_bound.h"

#include "render/lighting/lighting_shader.h"
#include "shared/light.h"
#include "study/constant_ids.h"
#include "study/light_bound_push.h"

namespace latelight::study {

namespace {

// A light whose range and spot cone include the surface.
shared::Light commonLight() {
  shared::Light light{.inverseRadius2 = shared::inverseRadius2(10), .intensity = {1, 0.9f, 0.8f}};
  shared::spotCone(0.5f, 1.0f, light.spotScale, light.spotOffset);
  return light;
}

}  // namespace

render::TechniqueInfo lightBound(uint32_t type, uint32_t lights) {
  const auto add = [=](const render::FrameContext& f, const render::Gbuffer& gbuffer) {
    render::ComputePass pass = render::lightingPass(f, gbuffer, "lighting bound", "light_bound.comp");
    pass.constants.push_back({kLightTypeConstant, type});
    addCompute(f, std::move(pass), [lights, frame = f.constants, visible = gbuffer.visible](graph::Context& context) {
      return shared::LightBoundPush{frame, render::surfacePush(visible, context), commonLight(), shared::vec3(1e-4f),
                                    lights};
    });
    return render::LightLists{};
  };
  return {.name = "bound", .description = "lights made up in registers", .add = add};
}

}  // namespace latelight::study
