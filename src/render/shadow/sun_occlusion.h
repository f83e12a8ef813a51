// The sun's shadow as a channel of the G-buffer, as Killzone 2 has it (Valient 2007, Deferred Rendering in Killzone 2):
// pixels that the sun may light are marked in stencil first, and only there shadow maps are looked up. Lighting then
// reads the channel.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class SunOcclusionPass {
 public:
  // The setup's layout has a sunTarget.
  SunOcclusionPass(vk::Device& device, const FrameSetup& setup);
  // After the geometry pass. Nothing where no directional light casts shadows.
  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

 private:
  std::vector<vk::BoundImage> images(graph::Context& context, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

  size_t target_;
  vk::Pipeline mark_, fill_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
