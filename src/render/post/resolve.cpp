#include "render/post/resolve.h"

namespace latelight::render {

namespace {

constexpr uint32_t kGroup = 16;  // local_size of both shaders

vk::BufferDesc hostBuffer(const std::string& name, uint64_t bytes) {
  return {.size = bytes, .kind = vk::MemoryKind::Readback, .name = name};
}

}  // namespace

AccumulatePass::AccumulatePass(vk::Device& device)
    : pipeline_(vk::makePipeline(device, vk::ComputeDesc{.shader = "accumulate.comp",
                                                         .bindings = {vk::Binding::Sampled, vk::Binding::Storage},
                                                         .name = "accumulate"})),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

void AccumulatePass::add(graph::Graph& graph, graph::ImageId frame, graph::ImageId sum, bool first) const {
  vk::ImageDesc desc = graph.desc(frame);
  graph.pass(
      graph::Stage::Post, "accumulate",
      {{frame, graph::Use::SampledCompute}, {sum, first ? graph::Use::StorageWrite : graph::Use::StorageReadWrite}},
      [=, this](graph::Context& context) {
        context.commands().bind(pipeline_,
                                {{context.image(frame).arrayView(), sampler_.get()}, {context.image(sum).arrayView()}},
                                uint32_t{first});
        context.commands().dispatch(desc.width, desc.height, desc.layers, kGroup, kGroup);
      });
}

ComposePass::ComposePass(vk::Device& device)
    : pipeline_(vk::makePipeline(
          device, vk::ComputeDesc{.shader = "compose.comp", .bindings = {vk::Binding::Sampled}, .name = "compose"})),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

graph::BufferId createPixels(graph::Graph& graph, graph::ImageId picture) {
  const vk::ImageDesc& desc = graph.desc(picture);
  return graph.create(hostBuffer("picture", uint64_t{4} * desc.width * desc.height * desc.layers));
}

graph::BufferId ComposePass::add(graph::Graph& graph, graph::ImageId picture, const ComposeSettings& settings) const {
  vk::ImageDesc desc = graph.desc(picture);
  graph::BufferId pixels = createPixels(graph, picture);
  graph.pass(graph::Stage::Post, "compose", {{picture, graph::Use::SampledCompute}, {pixels, graph::Use::StorageWrite}},
             [=, this](graph::Context& context) {
               context.commands().bind(pipeline_, {{context.image(picture).arrayView(), sampler_.get()}},
                                       ComposePush(settings, context.buffer(pixels).address()));
               context.commands().dispatch(desc.width, desc.height, desc.layers, kGroup, kGroup);
             });
  graph.exports(pixels, graph::Use::HostRead);
  return pixels;
}

graph::BufferId addReadback(graph::Graph& graph, graph::ImageId image) {
  vk::ImageDesc desc = graph.desc(image);
  graph::BufferId buffer = graph.create(hostBuffer(
      "read back " + desc.name, uint64_t{vk::texelBytes(desc.format)} * desc.width * desc.height * desc.layers));
  graph.pass(graph::Stage::Output, "read back " + desc.name,
             {{image, graph::Use::CopySource}, {buffer, graph::Use::CopyTarget}}, [=](graph::Context& context) {
               const vk::Image& source = context.image(image);
               VkBufferImageCopy region{.imageSubresource = {source.aspect(), 0, 0, desc.layers},
                                        .imageExtent = {desc.width, desc.height, 1}};
               vkCmdCopyImageToBuffer(context.get(), source.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                      context.buffer(buffer).get(), 1, &region);
             });
  graph.exports(buffer, graph::Use::HostRead);
  return buffer;
}

}  // namespace latelight::render
