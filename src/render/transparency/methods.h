// What the methods of drawing blended surfaces have in common, and their makers.
#pragma once

#include <string>
#include <vector>

#include "render/transparency/transparency.h"
#include "vk/pipeline.h"

namespace latelight::render {

std::unique_ptr<Transparency> makeExactTransparency(vk::Device& device, const GpuScene& scene, const FrameSetup& setup);
std::unique_ptr<Transparency> makeSortedTransparency(vk::Device& device, const GpuScene& scene,
                                                     const FrameSetup& setup);
std::unique_ptr<Transparency> makeWeightedTransparency(vk::Device& device, const GpuScene& scene,
                                                       const FrameSetup& setup);

// A pipeline that draws blended fragments (blended.glsl): tested against depth, which they leave alone. What lies
// exactly on an opaque surface, a decal, is seen.
struct BlendedTarget {
  std::string fragment;  // shader
  std::vector<VkFormat> colors;
  vk::Blend blend = vk::Blend::Replace;
  uint32_t samples = 1;  // those of the frame, or 1: then depth is that of pixels
};
vk::Pipeline makeBlendedPipeline(vk::Device& device, const GpuScene& scene, const FrameSetup& setup,
                                 const BlendedTarget& target);

// The blended draws of each view.
std::vector<std::vector<Draw>> blendedDraws(const FrameInputs& inputs);
bool anyDraw(const std::vector<std::vector<Draw>>& draws);

}  // namespace latelight::render
