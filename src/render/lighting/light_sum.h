// What techniques that add one light after the other share: the target they add in, and a word on long frames.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// 32-bit floats where the device can blend them: thousands of additions in 16 bits would be off by more than a display
// level.
VkFormat lightSumFormat(vk::Device& device);

// Warns of frames that draw very many lights one by one.
void warnOfManyPasses(const char* technique, uint64_t passes);

// Makes a sum of lights the lit picture: the mean of a pixel's samples where it has several, and no value above what
// the picture holds (of any sample, as no frame of a super-sampled picture has one).
void addFinishSum(const FrameContext& f, graph::ImageId sum, graph::ImageId light);

}  // namespace latelight::render
