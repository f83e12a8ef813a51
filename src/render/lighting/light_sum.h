// Shared by techniques that add lights one by one with blending: the target of the sum, and a warning about slow
// frames.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// 32-bit floats if the device can blend them, else kLightFormat: after thousands of additions in 16 bits the error
// would exceed one display level.
VkFormat lightSumFormat(vk::Device& device);

// Logs a warning if a frame draws very many lights one by one.
void warnOfManyPasses(const char* technique, uint64_t passes);

// Resolves a sum of lights to the lit picture: the mean of a pixel's samples, each clamped to the largest value that
// the picture can represent (as in each frame of a supersampled picture). With several samples, it applies fog.
void addFinishSum(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId sum);

}  // namespace latelight::render
