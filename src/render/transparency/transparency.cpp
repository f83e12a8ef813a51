#include "render/transparency/transparency.h"

#include "base/error.h"
#include "render/frame/lit_maps.h"
#include "render/layered/behind.h"
#include "render/lighting/forward/forward.h"
#include "render/lighting/reference/paths.h"
#include "render/settings/settings.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

static_assert(indexOf(TransparencyMethod::Exact) == kTransparencyExact);
static_assert(indexOf(TransparencyMethod::Sorted) == kTransparencySorted);
static_assert(indexOf(TransparencyMethod::Weighted) == kTransparencyWeighted);
static_assert(indexOf(TransparencyMethod::None) == kTransparencyNone);

bool blendedHaveLayers(const FrameContext& f) {
  return (visibleMaterials(f).translucent & shared::kMaterialLayered) != 0;
}

Bindings blendedMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::Use use) {
  Bindings maps = litMaps(f, gbuffer, use);
  if (!blendedHaveLayers(f)) return maps;
  if (gbuffer.behind)
    maps.sampled(gbuffer.behind, kBackgroundSampler);
  else
    maps.outside(f.environment.nothing());
  return maps;
}

ScenePipelines blendedPipelines(const FrameContext& f, const Bindings& maps, const BlendedTarget& target) {
  const bool everyLight = f.setup.transparency.everyLight || forwardLoop(f.device) == ForwardLoop::Plain;
  vk::GraphicsDesc desc;
  desc.vertex = target.vertex.empty() ? "scene.vert" : target.vertex;
  desc.vertexBuffers = sceneVertexBuffers(desc.vertex);
  desc.fragment = materialVariant(f.device, target.fragment);
  desc.samples = target.samples;
  desc.bindings = maps.kinds();
  desc.sceneSets = GpuMaterials::setBindings(f.device);
  desc.constants = f.setup.constants();
  desc.constants.push_back({kEveryLightConstant, everyLight ? 1u : 0u});
  desc.pushBytes = target.pushBytes;
  desc.colors = target.colors;
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  desc.depthWrite = false;
  desc.blend = target.blend;
  desc.name = target.fragment.name();
  const vk::PipelineRef plain = f.device.cache().pipeline(desc);
  ScenePipelines pipelines{plain, plain};
  if (f.scene.anyVast()) pipelines.vastOpaque = pipelines.vastMasked = f.device.cache().pipeline(forVast(desc));
  if (!blendedHaveLayers(f)) return pipelines;
  desc.fragment.coated = true;
  desc.constants.push_back({kLayersConstant, f.setup.layers});
  desc.name += " coated";
  pipelines.layered = f.device.cache().pipeline(desc);
  return pipelines;
}

void addTransparency(const FrameContext& f, Gbuffer gbuffer) {
  const uint32_t method = f.setup.transparency.method;
  if (method == kTransparencyNone || !anyBlended(f) || tracesPaths(f.setup)) return;
  if (visibleMaterials(f).translucent & shared::kMaterialTransmissive)
    gbuffer.behind = addTransmissionBackground(f, gbuffer.light);
  if (gbuffer.visible.ids) return addFragmentLists(f, gbuffer);
  switch (method) {
    case kTransparencyExact:
      return addFragmentLists(f, gbuffer);
    case kTransparencySorted:
      return addSortedTransparency(f, gbuffer);
    case kTransparencyWeighted:
      return addWeightedTransparency(f, gbuffer);
    default:
      fail(ExitCode::Internal, "Unknown transparency method {}.", method);
  }
}

}  // namespace latelight::render
