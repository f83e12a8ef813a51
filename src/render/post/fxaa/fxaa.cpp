#include "render/post/fxaa/fxaa.h"

namespace latelight::render {

FxaaPass::FxaaPass(vk::Device& device)
    : input_(vk::makePipeline(device, vk::ComputeDesc{.shader = "fxaa_input.comp",
                                                      .bindings = {vk::Binding::Sampled, vk::Binding::Storage},
                                                      .name = "fxaa input"})),
      fxaa_(vk::makePipeline(
          device, vk::ComputeDesc{.shader = "fxaa.comp", .bindings = {vk::Binding::Sampled}, .name = "fxaa"})),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

graph::BufferId FxaaPass::add(graph::Graph& graph, graph::ImageId picture, const ComposeSettings& settings) const {
  vk::ImageDesc desc = graph.desc(picture);
  desc = {.format = VK_FORMAT_R32G32B32A32_SFLOAT,  // so that what is left alone is rounded as without
          .width = desc.width,
          .height = desc.height,
          .layers = desc.layers,
          .name = "display"};
  const graph::ImageId display = graph.create(desc);
  graph.pass(graph::Stage::Post, "compose",
             {{picture, graph::Use::SampledCompute}, {display, graph::Use::StorageWrite}},
             [=, this](graph::Context& context) {
               context.commands().bind(
                   input_, {{context.image(picture).arrayView(), sampler_.get()}, {context.image(display).arrayView()}},
                   ComposePush(settings, 0));
               context.commands().dispatch(desc.width, desc.height, desc.layers, 16, 16);
             });
  const graph::BufferId pixels = createPixels(graph, picture);
  graph.pass(graph::Stage::Post, "fxaa", {{display, graph::Use::SampledCompute}, {pixels, graph::Use::StorageWrite}},
             [=, this](graph::Context& context) {
               context.commands().bind(fxaa_, {{context.image(display).arrayView(), sampler_.get()}},
                                       ComposePush(settings, context.buffer(pixels).address()));
               context.commands().dispatch(desc.width, desc.height, desc.layers, 16, 16);
             });
  graph.exports(pixels, graph::Use::HostRead);
  return pixels;
}

}  // namespace latelight::render
