// Multisampling: which samples of a pixel show one surface, and the depth of pixels that have several samples.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

// Four samples a pixel in their standard places, and what shades them: throws Error(NoDevice) where the device has not.
void requireSamples(const vk::Device& device, const FrameSetup& setup);

// Finds the surfaces of each pixel of a multisampled G-buffer (sample_surfaces.comp): the pixels with more than one are
// those that are shaded per sample.
class SampleSurfacesPass {
 public:
  SampleSurfacesPass(vk::Device& device, const FrameSetup& setup);
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};
inline constexpr VkFormat kSurfacesFormat = VK_FORMAT_R32_UINT;  // multisample.glsl

// One depth a pixel from that of its samples, for what comes after lighting.
class PixelDepthPass {
 public:
  explicit PixelDepthPass(vk::Device& device);
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId sampleDepth) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
