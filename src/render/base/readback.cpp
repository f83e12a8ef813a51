#include "render/base/readback.h"

#include <algorithm>

namespace latelight::render {

namespace {

vk::BufferDesc hostBuffer(const std::string& name, uint64_t bytes) {
  return {.size = bytes, .kind = vk::MemoryKind::Readback, .name = name};
}

}  // namespace

ResultTarget createResult(const Builder& b, const std::string& name, uint64_t viewBytes, size_t views) {
  const uint64_t bytes = viewBytes * views;
  const vk::BufferDesc desc = b.device.isCpu() ? hostBuffer(name, bytes) : vk::BufferDesc{.size = bytes, .name = name};
  return {.buffer = b.graph.create(desc), .viewBytes = viewBytes};
}

void addFill(const Builder& b, const ResultTarget& result, uint64_t viewBytes, size_t views,
             const std::vector<uint32_t>& words) {
  if (std::ranges::all_of(words, [&](uint32_t word) { return word == words.front(); })) {
    b.graph.pass(graph::Stage::Output, "fill", {{result.buffer, graph::Use::CopyTarget}}, [=](graph::Context& context) {
      for (size_t view = 0; view < views; ++view)
        vkCmdFillBuffer(context.get(), context.buffer(result.buffer).get(), result.offset + view * result.viewBytes,
                        viewBytes, words.front());
    });
    return;
  }
  // vkCmdFillBuffer() repeats a single word, so other patterns are copied from a short buffer.
  constexpr size_t kRepetitions = 1024;
  const uint64_t bytes = kRepetitions * words.size() * sizeof(uint32_t);
  const graph::BufferId pattern = addSmallBuffer(b, graph::Stage::Output, "fill pattern", bytes, {}, [=](auto&) {
    std::vector<uint32_t> repeated;
    for (size_t i = 0; i < kRepetitions; ++i) repeated.insert(repeated.end(), words.begin(), words.end());
    return repeated;
  });
  b.graph.pass(
      graph::Stage::Output, "fill", {{pattern, graph::Use::CopySource}, {result.buffer, graph::Use::CopyTarget}},
      [=](graph::Context& context) {
        std::vector<VkBufferCopy> copies;
        for (size_t view = 0; view < views; ++view)
          for (uint64_t at = 0; at < viewBytes; at += bytes)
            copies.push_back({0, result.offset + view * result.viewBytes + at, std::min(bytes, viewBytes - at)});
        vkCmdCopyBuffer(context.get(), context.buffer(pattern).get(), context.buffer(result.buffer).get(),
                        static_cast<uint32_t>(copies.size()), copies.data());
      });
}

void storeResults(const Builder& b, std::span<const graph::BufferId> results) {
  for (const graph::BufferId result : results)
    b.graph.exports(result, b.device.isCpu() ? graph::Use::HostRead : graph::Use::CopySource);
}

std::vector<graph::BufferId> copyToHost(const Builder& b, graph::Stage stage, const char* name,
                                        const std::vector<graph::BufferId>& from) {
  std::vector<graph::BufferId> host;
  std::vector<graph::Access> accesses;
  for (const graph::BufferId buffer : from) {
    const vk::BufferDesc& desc = b.graph.desc(buffer);
    host.push_back(b.graph.create(hostBuffer(desc.name + ", host", desc.size)));
    accesses.emplace_back(buffer, graph::Use::CopySource);
    accesses.emplace_back(host.back(), graph::Use::CopyTarget);
  }
  b.graph.pass(stage, name, std::move(accesses), [=](graph::Context& context) {
    for (size_t i = 0; i < from.size(); ++i) {
      const VkBufferCopy all{0, 0, context.buffer(from[i]).size()};
      vkCmdCopyBuffer(context.get(), context.buffer(from[i]).get(), context.buffer(host[i]).get(), 1, &all);
    }
  });
  for (const graph::BufferId copy : host) b.graph.exports(copy, graph::Use::HostRead);
  return host;
}

std::vector<graph::BufferId> addReadback(const Builder& b, std::span<const graph::BufferId> results) {
  const std::vector<graph::BufferId> from(results.begin(), results.end());
  if (!b.device.isCpu() && !from.empty()) return copyToHost(b, graph::Stage::Output, "read back", from);
  storeResults(b, from);
  return from;
}

graph::BufferId addReadback(const Builder& b, graph::BufferId result) {
  return addReadback(b, std::span(&result, 1)).front();
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
