// The passes that shade layered materials: drawn again at equal depth (raster hardware), or in a compute shader from
// the visibility buffer (raster compute).
#include "render/layered/layered.h"

#include "render/base/pixel_group.h"
#include "render/frame/lit_maps.h"
#include "render/layered/layered_push.h"
#include "render/lighting/forward/forward.h"
#include "render/lighting/light_lists.h"
#include "render/lighting/reference/paths.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

// The coats of opaque surfaces. Transmissive materials are shaded with the blended surfaces.
vk::Constant opaqueLayers(const FrameConfig& setup) {
  return {kLayersConstant, setup.layers & ~(shared::kLayerTransmission | shared::kLayerDispersion)};
}

// Adds the mean of each pixel's samples to the picture.
void addSamples(const FrameContext& f, graph::ImageId samples, graph::ImageId light) {
  Bindings bindings(f.device);
  bindings.sampled(samples).storage(light, graph::Use::StorageReadWrite);
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "layered samples",
              .shader = "layered_samples.comp",
              .bindings = std::move(bindings),
              .size = f.pixels()},
             NoPush{});
}

void recordLayered(graph::Context& context, const FrameContext& f, const DeviceDraws& draws, uint32_t view,
                   SceneBinder& binder) {
  for (const Draw& draw : draws[view]) {
    if (!(f.scene.materials().record(draw.material).flags & shared::kMaterialLayered)) continue;
    binder.bind(draw);
    recordDraw(context, f.scene, draw);
  }
}

// Draws instances with layered materials again with the depth test EQUAL. With one sample per pixel their light
// replaces the black that the lighting technique wrote; with several it is written to a separate target and then added.
void drawLayered(const FrameContext& f, const Gbuffer& gbuffer, const HardwareVisibility& hardware) {
  const bool several = f.setup.samples > 1;
  const graph::ImageId target =
      several ? createTarget(f, kLightFormat, "layered light of samples", f.setup.samples) : gbuffer.light;
  const Bindings maps = litMaps(f, gbuffer, graph::Use::SampledFragment);
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.fragment = f.setup.variant("layered.frag");
  desc.constants.push_back(opaqueLayers(f.setup));
  desc.constants.push_back({kPlainLoopConstant, forwardLoop(f.device) == ForwardLoop::Plain ? 1u : 0u});
  desc.bindings = maps.kinds();
  desc.name = "layered";
  std::vector<graph::ImageId> colors{target};
  if (f.setup.countLights) colors.push_back(gbuffer.lightCounts);
  for (const graph::ImageId color : colors) desc.colors.push_back(f.graph.desc(color).format);
  const ScenePipelines pipelines = scenePipelines(f, desc);
  std::vector<graph::Access> accesses = maps.accesses();
  accesses.emplace_back(gbuffer.sampleDepth, graph::Use::DepthTest);
  for (const graph::ImageId color : colors)
    accesses.emplace_back(color, several ? graph::Use::ColorAttachment : graph::Use::ColorAttachmentLoad);
  f.graph.pass(graph::Stage::Lighting, desc.name, std::move(accesses), [=, &hardware](graph::Context& context) {
    const std::vector<vk::BoundImage> images = maps.images(context);
    for (uint32_t view = 0; view < f.viewCount(); ++view) {
      const ViewRendering rendering(context, f, view, colors, {gbuffer.sampleDepth, false},
                                    several ? ColorUse::Clear : ColorUse::Keep);
      SceneBinder binder(context, f.scene, hardware.solid(), drawnView(f, view), pipelines, images);
      recordLayered(context, f, hardware.solid(), view, binder);
    }
  });
  if (several) addSamples(f, target, gbuffer.light);
}

// Returns the light lists to use; null if none. With one sample per pixel, those of the lighting technique are built
// for the same surfaces. On lavapipe, shading with lists requires twice the time of the light tree, because a loop
// around the loop over lights keeps the complete layered surface in memory.
LightLists listsOfPixels(const FrameContext& f, const Gbuffer& gbuffer) {
  if (f.setup.samples > 1 || f.device.hasCpuShaders()) return {};
  return gbuffer.lightLists;
}

// Shades the pixels whose visible triangles have a layered material.
void shadeLayered(const FrameContext& f, const Gbuffer& gbuffer) {
  Bindings bindings = litMaps(f, gbuffer, graph::Use::SampledCompute);
  bindings.storage(gbuffer.light, graph::Use::StorageReadWrite);
  bindings.storage(gbuffer.lightCounts, graph::Use::StorageReadWrite);
  const LightLists lists = listsOfPixels(f, gbuffer);
  ComputePass pass{.stage = graph::Stage::Lighting,
                   .name = "layered",
                   .shader = "layered.comp",
                   .bindings = std::move(bindings),
                   .size = f.pixels(),
                   .constants = f.setup.constants(),
                   .buffers = listAccesses(lists),
                   .groupX = shared::kPixelGroupX,
                   .groupY = shared::kPixelGroupY};
  const std::vector<vk::Constant> listed = listConstants(lists);
  pass.constants.insert(pass.constants.end(), listed.begin(), listed.end());
  pass.constants.insert(pass.constants.end(), {{kSamplesConstant, f.setup.samples}, opaqueLayers(f.setup)});
  readVisibleSurfaces(f, gbuffer.visible, pass);
  addCompute(f, std::move(pass), [lists, frame = f.constants, visible = gbuffer.visible](graph::Context& context) {
    return shared::LayeredPush{
        .frame = frame, .shown = surfacePush(visible, context), .lists = pushedLists(lists, context)};
  });
}

}  // namespace

void addLayered(const FrameContext& f, const Gbuffer& gbuffer) {
  if (!(visibleMaterials(f).solid & shared::kMaterialLayered) || tracesPaths(f.setup)) return;
  if (gbuffer.visible.ids) return shadeLayered(f, gbuffer);
  drawLayered(f, gbuffer, hardwareOf(f, "layered"));
}

}  // namespace latelight::render
