#include "render/post/resolve.h"

#include "render/post/accumulate_push.h"

namespace latelight::render {

namespace {

vk::BufferDesc hostBuffer(const std::string& name, uint64_t bytes) {
  return {.size = bytes, .kind = vk::MemoryKind::Readback, .name = name};
}

}  // namespace

void addAccumulate(const Builder& b, graph::ImageId frame, graph::ImageId sum, bool first) {
  const graph::Use use = first ? graph::Use::StorageWrite : graph::Use::StorageReadWrite;
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "accumulate",
              .shader = "accumulate.comp",
              .bindings = Bindings(b.device).sampled(frame).storage(sum, use),
              .size = texels(b.graph, frame)},
             shared::AccumulatePush{first});
}

shared::ComposePush composePush(const ComposeSettings& settings, VkDeviceAddress pixels) {
  return {pixels, settings.scale, settings.tonemap, settings.background};
}

graph::BufferId addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings) {
  return addFinalPass(b, "compose", picture, settings);
}

graph::BufferId addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture,
                             const ComposeSettings& settings) {
  const glm::uvec3 size = texels(b.graph, picture);
  const graph::BufferId pixels = b.graph.create(hostBuffer("picture", uint64_t{4} * size.x * size.y * size.z));
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = name,
              .shader = name + ".comp",
              .bindings = Bindings(b.device).sampled(picture),
              .size = size,
              .buffers = {{pixels, graph::Use::StorageWrite}}},
             [=](graph::Context& context) { return composePush(settings, context.buffer(pixels).address()); });
  b.graph.exports(pixels, graph::Use::HostRead);
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
