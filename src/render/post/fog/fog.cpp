#include "render/post/fog/fog.h"

namespace latelight::render {

FogPass::FogPass(vk::Device& device)
    : pipeline_(vk::makePipeline(device, vk::ComputeDesc{.shader = "fog.comp",
                                                         .bindings = {vk::Binding::Sampled, vk::Binding::Storage},
                                                         .name = "fog"})),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

void FogPass::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  graph.pass(
      graph::Stage::Post, "fog",
      {{gbuffer.depth, graph::Use::SampledCompute}, {gbuffer.light, graph::Use::StorageReadWrite}},
      [this, inputs, gbuffer](graph::Context& context) {
        context.commands().bind(
            pipeline_,
            {{context.image(gbuffer.depth).arrayView(), sampler_.get()}, {context.image(gbuffer.light).arrayView()}},
            inputs.constants);
        context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
      });
}

}  // namespace latelight::render
