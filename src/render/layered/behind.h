// What transmissive surfaces show: the opaque scene with its background and fog, the sharper of which the blurred ones
// are made.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// Between the texels of a level.
inline constexpr vk::SamplerDesc kBehindSampler{.mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                                .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};

// The picture and its levels in one image, as layered/behind.glsl finds them; each a layer a view.
graph::ImageId addBehind(const FrameContext& f, graph::ImageId picture);

}  // namespace latelight::render
