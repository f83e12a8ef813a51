// What techniques that add one light after the other share: the target they add in, and a word on long frames.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

// 32-bit floats where the device can blend them: thousands of additions in 16 bits would be off by more than a display
// level.
VkFormat lightSumFormat(vk::Device& device);

// Warns of frames that draw very many lights one by one.
void warnOfManyPasses(const char* technique, uint64_t passes);

// Makes a sum of lights the lit picture: the mean of a pixel's samples where it has several, and no value above what
// the picture holds (of any sample, as no frame of a super-sampled picture has one).
class FinishSum {
 public:
  FinishSum(vk::Device& device, const FrameSetup& setup);
  void add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId sum, graph::ImageId light) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
