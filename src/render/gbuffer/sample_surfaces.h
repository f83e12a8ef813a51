// Multisampling: which samples of a pixel show one surface, and the depth of pixels that have several samples.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// Four samples a pixel in their standard places, and what shades them: throws Error(NoDevice) where the device has not.
void requireSamples(const vk::Device& device, const FrameSetup& setup);

inline constexpr VkFormat kSurfacesFormat = VK_FORMAT_R32_UINT;  // multisample.glsl

// Per-sample classification: the surfaces of each pixel of a multisampled G-buffer (sample_surfaces.comp). Pixels with
// more than one are those that are shaded per sample.
graph::ImageId addSampleSurfaces(const FrameContext& f, const Gbuffer& gbuffer);

// Depth resolve: one depth a pixel from that of its samples, for what comes after lighting.
graph::ImageId addDepthResolve(const FrameContext& f, graph::ImageId sampleDepth);

}  // namespace latelight::render
