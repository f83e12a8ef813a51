// Fog over what is lit so far, by the depth of what is opaque (docs/post/fog.md). What is drawn afterwards brings its
// own, with the same functions of shared/fog.h.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class FogPass {
 public:
  explicit FogPass(vk::Device& device);
  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
