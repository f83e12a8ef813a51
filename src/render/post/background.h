// Draws the environment where nothing else is (--background hdri).
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class BackgroundPass {
 public:
  explicit BackgroundPass(vk::Device& device);
  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

 private:
  vk::Pipeline pipeline_;
};

}  // namespace latelight::render
