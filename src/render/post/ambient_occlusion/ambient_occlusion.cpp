// The passes of GTAO: occlusion from the depth buffer ("hidden"), then a separable average, first along x ("hidden,
// averaged across"), then along y ("ambient occlusion").
#include "render/post/ambient_occlusion/ambient_occlusion.h"

#include "render/lens/lens_rays.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"
#include "render/post/ambient_occlusion/ambient_occlusion_push.h"
#include "render/settings/settings.h"

namespace latelight::render {

static_assert(indexOf(AmbientOcclusion::None) == kAoNone);
static_assert(indexOf(AmbientOcclusion::Gtao) == kAoGtao);

namespace {

// The maximum reach as a fraction of the picture's height. Beyond it, samples would be so far apart that they miss
// occluders between them.
constexpr float kReachShare = 0.5f;
// Fraction of the radius: pixels that are farther than this from each other's plane are not averaged.
constexpr float kToleranceShare = 0.3f;

graph::ImageId addOcclusion(const FrameContext& f, const Gbuffer& gbuffer) {
  const graph::ImageId occluded = createTarget(f, kAoFormat, "hidden");
  Bindings bindings(f.device);
  vk::ShaderKey shader = "gtao_depth.comp";
  // Forward techniques write no normals, and with several samples per pixel there is no single normal. Normals are then
  // derived from depth.
  const bool surfaces = !f.setup.lighting->forward && f.setup.samples == 1;
  if (surfaces) {
    shader = {"gtao.comp", f.setup.layout->file};
    bindings.sampled(gbuffer.targets);
  }
  bindings.sampled(gbuffer.depth).storage(occluded, graph::Use::StorageWrite);
  ComputePass pass{.stage = graph::Stage::Lighting,
                   .name = "ambient occlusion",
                   .shader = shader,
                   .bindings = bindings,
                   .size = f.pixels(),
                   .constants = f.setup.constants()};
  if (surfaces) readSurfaces(f, gbuffer, pass);
  shared::OcclusionPush push{
      .frame = f.constants, .radius = f.aoRadius, .reach = kReachShare * static_cast<float>(f.height)};
  if (f.lens) {
    push.lens = f.graph.constants(std::as_bytes(std::span(f.lens->lenses)));
    push.aperture = f.lens->aperture, push.focus = f.lens->focus;
  }
  addCompute(f, std::move(pass), [push, visible = gbuffer.visible](graph::Context& context) {
    shared::OcclusionPush filled = push;
    filled.shown = surfacePush(visible, context);
    return filled;
  });
  return occluded;
}

// Averages occlusion along one axis. The pass along axis 1 also converts occlusion to visibility.
graph::ImageId addDenoise(const FrameContext& f, graph::ImageId depth, graph::ImageId occluded, uint32_t axis) {
  const graph::ImageId result = createTarget(f, kAoFormat, axis == 0 ? "hidden, averaged across" : "ambient occlusion");
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "ambient occlusion denoise",
              .shader = "ambient_occlusion_denoise.comp",
              .bindings = Bindings(f.device).sampled(depth).sampled(occluded).storage(result, graph::Use::StorageWrite),
              .size = f.pixels(),
              .constants = {{kLastAxisConstant, axis}, {kLensConstant, f.lens ? 1u : 0u}}},
             shared::DenoisePush{f.constants, kToleranceShare * f.aoRadius, f.aoStrength, kToleranceShare, 0});
  return result;
}

}  // namespace

graph::ImageId addAmbientOcclusion(const FrameContext& f, const Gbuffer& gbuffer) {
  if (f.setup.ambientOcclusion == kAoNone) return {};
  const graph::ImageId occluded = addOcclusion(f, gbuffer);
  return addDenoise(f, gbuffer.depth, addDenoise(f, gbuffer.depth, occluded, 0), 1);
}

}  // namespace latelight::render
