// A compute shader that lights a G-buffer. Set 0 is the same for all of them: what gbuffer_read.glsl has, then what
// lit_maps.glsl has.
#pragma once

#include <string>
#include <vector>

#include "render/frame.h"
#include "vk/commands.h"
#include "vk/pipeline.h"

namespace latelight::render {

// What gbuffer_read.glsl samples: the layout's targets, depth, and with several samples a pixel the light they had and
// the surfaces of pixels.
size_t gbufferInputs(const FrameSetup& setup);
std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer);

class LightingShader {
 public:
  // `file`: the shader's, compiled for each layout. `own`: its constants beside the setup's, from kFirstOwnConstant.
  // `more`: its bindings after the lit maps'.
  LightingShader(vk::Device& device, const FrameSetup& setup, const std::string& file,
                 const std::vector<vk::Constant>& own = {}, const std::vector<vk::Binding>& more = {});

  // What a pass that runs it declares.
  static std::vector<graph::Access> accesses(const Gbuffer& gbuffer);

  // Runs it over every pixel of every view, in workgroups of 16 by 16.
  template <typename Push>
  void dispatch(graph::Context& context, const FrameInputs& inputs, const Gbuffer& gbuffer, const Push& push,
                const std::vector<vk::BoundImage>& more = {}) const {
    std::vector<vk::BoundImage> bound = images(context, inputs, gbuffer);
    bound.insert(bound.end(), more.begin(), more.end());
    context.commands().bind(pipeline_, bound, push);
    context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
  }

 private:
  std::vector<vk::BoundImage> images(graph::Context& context, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
