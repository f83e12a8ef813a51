#include "render/base/pass.h"

namespace latelight::render {

Bindings& Bindings::sampled(graph::ImageId image, const vk::SamplerDesc& sampler) {
  slots_.push_back({vk::Binding::Sampled, image, use_, {.sampler = device_.cache().sampler(sampler)}});
  return *this;
}

Bindings& Bindings::sampled(const std::vector<graph::ImageId>& images) {
  for (const graph::ImageId image : images) sampled(image);
  return *this;
}

Bindings& Bindings::storage(graph::ImageId image, graph::Use use) {
  slots_.push_back({vk::Binding::Storage, image, use, {}});
  return *this;
}

Bindings& Bindings::outside(vk::BoundImage image, vk::Binding kind) {
  slots_.push_back({kind, {}, use_, image});
  return *this;
}

std::vector<vk::Binding> Bindings::kinds() const {
  std::vector<vk::Binding> kinds;
  for (const Slot& slot : slots_) kinds.push_back(slot.kind);
  return kinds;
}

std::vector<graph::Access> Bindings::accesses() const {
  std::vector<graph::Access> accesses;
  for (const Slot& slot : slots_)
    if (slot.image) accesses.emplace_back(slot.image, slot.use);
  return accesses;
}

std::vector<vk::BoundImage> Bindings::images(graph::Context& context) const {
  std::vector<vk::BoundImage> images;
  for (const Slot& slot : slots_) {
    images.push_back(slot.bound);
    if (!slot.image) continue;
    const vk::Image& image = context.image(slot.image);
    images.back().view = slot.kind == vk::Binding::Storage ? image.storageView() : image.arrayView();
  }
  return images;
}

std::vector<graph::Access> accessesOf(const ComputePass& pass) {
  std::vector<graph::Access> accesses = pass.bindings.accesses();
  accesses.insert(accesses.end(), pass.buffers.begin(), pass.buffers.end());
  if (pass.groups) accesses.emplace_back(pass.groups, graph::Use::IndirectRead);
  return accesses;
}

uint64_t trafficBytes(const graph::Graph& graph, const ComputePass& pass, std::span<const graph::Access> accesses) {
  if (!pass.fullImage) return 0;
  uint64_t bytes = 0;
  for (const graph::Access& access : accesses) {
    if (access.buffer && access.use == graph::Use::StorageWrite) bytes += graph.desc(access.buffer).size;
    if (!access.image || texels(graph, access.image) != pass.size) continue;
    const vk::ImageDesc& image = graph.desc(access.image);
    const uint64_t once =
        uint64_t{image.width} * image.height * image.layers * image.samples * vk::texelBytes(image.format);
    bytes += once * (uint64_t{graph::reads(access.use)} + uint64_t{graph::writes(access.use)});
  }
  return bytes;
}

void addClear(const Builder& b, graph::Stage stage, const char* name, const std::vector<graph::BufferId>& cleared,
              const std::vector<graph::BufferId>& discarded) {
  std::vector<graph::Access> accesses;
  for (const auto& buffers : {cleared, discarded})
    for (const graph::BufferId buffer : buffers) accesses.emplace_back(buffer, graph::Use::CopyTarget);
  b.graph.pass(stage, name, std::move(accesses), [=](graph::Context& context) {
    for (const graph::BufferId buffer : cleared)
      vkCmdFillBuffer(context.get(), context.buffer(buffer).get(), 0, VK_WHOLE_SIZE, 0);
  });
}

}  // namespace latelight::render
