// Shared by techniques that add one light after the other: the target of the sum, and a warning about long frames.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// 32-bit floats where the device can blend them: thousands of additions in 16 bits would be off by more than a display
// level.
VkFormat lightSumFormat(vk::Device& device);

// Warns of frames that draw very many lights one by one.
void warnOfManyPasses(const char* technique, uint64_t passes);

// Turns a sum of lights into the lit picture: the mean of a pixel's samples where it has several, each sample clamped
// to the largest value that the picture can hold (as in each frame of a super-sampled picture).
void addFinishSum(const FrameContext& f, graph::ImageId sum, graph::ImageId light);

}  // namespace latelight::render
