// FXAA (docs/post/fxaa.md): composes the picture and softens its jagged edges.
#pragma once

#include "graph/graph.h"
#include "render/post/resolve.h"
#include "vk/pipeline.h"

namespace latelight::render {

class FxaaPass {
 public:
  explicit FxaaPass(vk::Device& device);
  // As ComposePass::add.
  graph::BufferId add(graph::Graph& graph, graph::ImageId picture, const ComposeSettings& settings) const;

 private:
  vk::Pipeline input_, fxaa_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
