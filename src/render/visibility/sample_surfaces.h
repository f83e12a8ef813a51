// Multisampling (MSAA): the surfaces of a pixel's samples, and the depth of multisampled pixels.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Requires four samples per pixel at the standard locations, and the features to shade them. Throws Error(NoDevice) if
// the device lacks these.
void requireSamples(const vk::Device& device, const FrameConfig& setup);

inline constexpr VkFormat kSurfacesFormat = VK_FORMAT_R32_UINT;  // shared/samples.h

// Creates the image of the pixels' surfaces, for a frame with several samples per pixel.
graph::ImageId createSurfaces(const FrameContext& f);

// Per-sample classification: the surfaces of each pixel of a multisampled G-buffer (sample_surfaces.comp). Pixels with
// more than one are shaded per sample.
graph::ImageId addSampleSurfaces(const FrameContext& f, const Gbuffer& gbuffer);

// Depth resolve: adds one depth per pixel, from those of its samples, for the passes after lighting.
graph::ImageId addDepthResolve(const FrameContext& f, graph::ImageId sampleDepth);

}  // namespace latelight::render
