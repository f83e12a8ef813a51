// Motion of every pixel: a pass of its own, drawn only where it is asked for, after whichever frame or data pass left
// the depth.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

// What it is for: to find a pixel in the frame before, in half floats; or data outputs, in floats.
enum class MotionUse { Reproject, Data };

class MotionPass {
 public:
  MotionPass(vk::Device& device, const GpuScene& scene, MotionUse use);
  // R16G16B16A16_SFLOAT or R32G32B32A32_SFLOAT: xy to the frame before, zw to the frame after. Pixels, y down, without
  // jitter.
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth) const;

 private:
  VkFormat format_;
  vk::Pipeline background_, opaque_, masked_;
};

}  // namespace latelight::render
