#include "render/transparency/transparency.h"

#include <algorithm>

#include "base/error.h"
#include "render/lighting/forward/forward.h"
#include "render/lit_maps.h"
#include "render/transparency/methods.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

vk::Pipeline makeBlendedPipeline(vk::Device& device, const GpuScene& scene, const FrameSetup& setup,
                                 const BlendedTarget& target) {
  const bool everyLight = setup.transparency.everyLight || forwardLoop(device) == ForwardLoop::Plain;
  vk::GraphicsDesc desc;
  desc.vertex = "scene.vert";
  desc.fragment = target.fragment;
  desc.samples = target.samples;
  appendLitBindings(desc.bindings);
  desc.materialSet = scene.materialSetLayout();
  desc.constants = setup.constants();
  desc.constants.push_back({kFirstOwnConstant, everyLight ? 1u : 0u});
  desc.colors = target.colors;
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  desc.depthWrite = false;
  desc.blend = target.blend;
  desc.name = target.fragment;
  return vk::makePipeline(device, desc);
}

std::vector<std::vector<Draw>> blendedDraws(const FrameInputs& inputs) {
  std::vector<std::vector<Draw>> draws;
  for (const shared::View& view : inputs.views) draws.push_back(inputs.scene.visibleBlended(view, inputs.atCentres));
  return draws;
}

bool anyDraw(const std::vector<std::vector<Draw>>& draws) {
  return std::any_of(draws.begin(), draws.end(), [](const std::vector<Draw>& view) { return !view.empty(); });
}

std::unique_ptr<Transparency> makeTransparency(vk::Device& device, const GpuScene& scene, const FrameSetup& setup) {
  if (!anyBlended(scene)) return nullptr;
  switch (setup.transparency.method) {
    case kTransparencyExact:
      return makeExactTransparency(device, scene, setup);
    case kTransparencySorted:
      return makeSortedTransparency(device, scene, setup);
    case kTransparencyWeighted:
      return makeWeightedTransparency(device, scene, setup);
    case kTransparencyNone:
      return nullptr;
    default:
      fail(ExitCode::Internal, "There is no method of transparency {}.", setup.transparency.method);
  }
}

}  // namespace latelight::render
