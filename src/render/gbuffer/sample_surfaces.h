// Multisampling: which samples of a pixel show one surface, and the depth of pixels that have several samples.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Four samples a pixel at the standard locations, and the features to shade them: throws Error(NoDevice) where the
// device lacks these.
void requireSamples(const vk::Device& device, const FrameConfig& setup);

inline constexpr VkFormat kSurfacesFormat = VK_FORMAT_R32_UINT;  // shared/samples.h

// The image for the surfaces of pixels, of a frame with several samples.
graph::ImageId createSurfaces(const FrameContext& f);

// Per-sample classification: the surfaces of each pixel of a multisampled G-buffer (sample_surfaces.comp). Pixels with
// more than one are shaded per sample.
graph::ImageId addSampleSurfaces(const FrameContext& f, const Gbuffer& gbuffer);

// Depth resolve: one depth per pixel from those of its samples, for the passes after lighting.
graph::ImageId addDepthResolve(const FrameContext& f, graph::ImageId sampleDepth);

}  // namespace latelight::render
