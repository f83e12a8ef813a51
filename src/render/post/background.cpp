#include "render/post/background.h"

namespace latelight::render {

BackgroundPass::BackgroundPass(vk::Device& device)
    : pipeline_(vk::makePipeline(device, vk::ComputeDesc{.shader = "background.comp",
                                                         .bindings = {vk::Binding::Storage, vk::Binding::Sampled},
                                                         .name = "background"})) {}

void BackgroundPass::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  graph.pass(graph::Stage::Post, "background", {{gbuffer.light, graph::Use::StorageReadWrite}},
             [this, inputs, gbuffer](graph::Context& context) {
               struct {
                 VkDeviceAddress frame;
               } push{inputs.constants};
               context.commands().bind(
                   pipeline_, {{context.image(gbuffer.light).arrayView()}, inputs.environment.radiance()}, push);
               context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16,
                                           16);
             });
}

}  // namespace latelight::render
