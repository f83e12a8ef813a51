// Transmission background: the picture of the opaque scene with background and fog, and a pyramid of blurred levels
// computed from it, which rough transmissive surfaces sample.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Bilinear within a level.
inline constexpr vk::SamplerDesc kBackgroundSampler{.mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                                    .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                    .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};

// Adds the passes that create the pyramid. Returns one image with the picture and all levels, in the arrangement of
// behind_push.h, with one layer per view.
graph::ImageId addTransmissionBackground(const FrameContext& f, graph::ImageId picture);

}  // namespace latelight::render
