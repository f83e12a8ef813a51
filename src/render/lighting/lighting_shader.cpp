#include "render/lighting/lighting_shader.h"

#include "render/base/pixel_group.h"
#include "render/frame/lit_maps.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

// Returns the area lights that a pass shades without shadows, kAreaLights*. Paths find them on their own, and passes
// after the technique's add other light to the picture.
uint32_t areaLightsOf(const FrameConfig& setup, PreservedByLighting kept) {
  if (kept.picture || setup.indirect || setup.lighting->traces) return shared::kAreaLightsNone;
  if (setup.areaLights && setup.areaShadowRays) return shared::kAreaLightsUnshadowed;
  return setup.areaLights;
}

}  // namespace

std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer) {
  std::vector<graph::ImageId> images = gbuffer.targets;
  images.push_back(gbuffer.sampleDepth);
  if (gbuffer.surfaces && !gbuffer.targets.empty()) images.push_back(gbuffer.sampleLight);
  if (gbuffer.surfaces) images.push_back(gbuffer.surfaces);
  return images;
}

ComputePass lightingPass(const FrameContext& f, const Gbuffer& gbuffer, const std::string& name,
                         const std::string& file, PreservedByLighting kept) {
  Bindings bindings(f.device);
  bindings.sampled(gbufferInputs(gbuffer));
  // With several samples per pixel, the geometry pass writes its light to another image; in a layout without targets it
  // writes none.
  const bool reads = kept.picture || (!gbuffer.surfaces && !gbuffer.targets.empty());
  bindings.storage(gbuffer.light, reads ? graph::Use::StorageReadWrite : graph::Use::StorageWrite);
  bindings.storage(gbuffer.lightCounts, kept.counts ? graph::Use::StorageReadWrite : graph::Use::StorageWrite);
  appendLitMaps(bindings, f, gbuffer);
  FrameConfig setup = f.setup;
  setup.areaLights = areaLightsOf(f.setup, kept);
  std::vector<vk::Constant> constants = setup.constants();
  constants.push_back({kSamplesConstant, f.setup.samples});
  const bool layered = (visibleMaterials(f).solid & shared::kMaterialLayered) != 0;
  constants.push_back({kSomeShadedSeparatelyConstant, layered ? 1u : 0u});
  ComputePass pass{.stage = graph::Stage::Lighting,
                   .name = name,
                   .shader = f.setup.variant({file, f.setup.layout->file}),
                   .bindings = std::move(bindings),
                   .size = f.pixels(),
                   .constants = std::move(constants),
                   .groupX = shared::kPixelGroupX,
                   .groupY = shared::kPixelGroupY,
                   .fullImage = true};
  readSurfaces(f, gbuffer, pass);
  return pass;
}

void readSurfaces(const FrameContext& f, const Gbuffer& gbuffer, ComputePass& pass) {
  if (!f.setup.layout->hasTargets()) readVisibleSurfaces(f, gbuffer.visible, pass);
}

}  // namespace latelight::render
