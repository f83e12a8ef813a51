// Helpers that declare compute passes. Each image's binding, use and descriptor are declared once.
#pragma once

#include <concepts>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "graph/graph.h"
#include "render/base/constant_ids.h"
#include "vk/object_cache.h"

namespace latelight::render {

// A graph under construction, and the device that will run it.
struct Builder {
  vk::Device& device;
  graph::Graph& graph;
  bool worlds = false;  // each view has its own shared::FrameConstants: with worlds, or different exposures
};

// Descriptor set 0 of a shader, binding by binding.
class Bindings {
 public:
  // `use`: the use of sampled images, SampledCompute or SampledFragment.
  explicit Bindings(vk::Device& device, graph::Use use = graph::Use::SampledCompute) : device_(device), use_(use) {}
  Bindings& sampled(graph::ImageId image) { return sampled(image, vk::kNearestSampler); }  // for texelFetch() only
  Bindings& sampled(graph::ImageId image, const vk::SamplerDesc& sampler);
  Bindings& sampled(const std::vector<graph::ImageId>& images);
  Bindings& storage(graph::ImageId image, graph::Use use);  // StorageRead, StorageWrite or StorageReadWrite
  Bindings& outside(vk::BoundImage image, vk::Binding kind = vk::Binding::Sampled);  // external to the graph

  std::vector<vk::Binding> kinds() const;
  std::vector<graph::Access> accesses() const;
  std::vector<vk::BoundImage> images(graph::Context& context) const;

 private:
  struct Slot {
    vk::Binding kind;
    graph::ImageId image;  // none: external to the graph
    graph::Use use;
    vk::BoundImage bound;  // without a view if `image` is set
  };
  vk::Device& device_;
  graph::Use use_;
  std::vector<Slot> slots_;
};

struct ComputePass {
  graph::Stage stage;
  std::string name;
  vk::ShaderKey shader;
  Bindings bindings;
  glm::uvec3 size{1};                     // invocations: pixels and layers; unused if `groups` is set
  std::vector<vk::Constant> constants{};  // specialization constants
  std::vector<graph::Access> buffers{};   // accessed by address
  uint32_t groupX = 16, groupY = 16;      // local_size of the shader
  bool fullImage = false;    // each invocation accesses its texel of all images of this size and buffers it writes
  graph::BufferId groups{};  // indirect dispatch: holds the workgroup counts, at groupsOffset
  VkDeviceSize groupsOffset = 0;
  VkDescriptorSet sceneSet = VK_NULL_HANDLE;  // set 1, with sceneBindings
  std::vector<vk::Binding> sceneBindings{};
};

// Returns the resources that a pass accesses.
std::vector<graph::Access> accessesOf(const ComputePass& pass);

// Returns the bytes that a pass with `fullImage` reads and writes; 0 for other passes.
uint64_t trafficBytes(const graph::Graph& graph, const ComputePass& pass, std::span<const graph::Access> accesses);

struct NoPush {};  // for shaders without push constants
template <typename Constants>
constexpr uint32_t pushBytes() {
  return std::is_empty_v<Constants> ? 0 : sizeof(Constants);
}

// Returns a pass's pipeline, which the first request for it creates.
template <typename Constants>
vk::PipelineRef pipelineOf(const Builder& b, const ComputePass& pass) {
  vk::ComputeDesc desc{.shader = pass.shader,
                       .bindings = pass.bindings.kinds(),
                       .constants = pass.constants,
                       .pushBytes = pushBytes<Constants>(),
                       .name = pass.name};
  if (b.worlds) desc.constants.push_back({kWorldsConstant, 1});
  if (pass.sceneSet) desc.sceneSets = {pass.sceneBindings};
  return b.device.cache().pipeline(desc);
}

// Adds a pass of one dispatch; push(context) returns its push constants.
template <std::invocable<graph::Context&> Push>
void addCompute(const Builder& b, ComputePass pass, Push push) {
  using Constants = std::invoke_result_t<Push, graph::Context&>;
  const vk::PipelineRef pipeline = pipelineOf<Constants>(b, pass);
  std::vector<graph::Access> accesses = accessesOf(pass);
  const auto [stage, name] = std::pair(pass.stage, pass.name);
  const uint64_t bytes = trafficBytes(b.graph, pass, accesses);
  b.graph.pass(
      stage, name, std::move(accesses),
      [pipeline, pass = std::move(pass), push = std::move(push)](graph::Context& context) {
        const Constants constants = push(context);
        const std::vector<vk::BoundImage> images = pass.bindings.images(context);
        context.commands().bind(pipeline.get(), std::span(images),
                                std::as_bytes(std::span(&constants, 1)).first(pushBytes<Constants>()));
        if (pass.sceneSet) context.commands().bindSceneSets(pipeline.get(), std::span(&pass.sceneSet, 1));
        if (pass.groups)
          context.commands().dispatchIndirect(context.buffer(pass.groups), pass.groupsOffset);
        else
          context.commands().dispatch(pass.size.x, pass.size.y, pass.size.z, pass.groupX, pass.groupY);
      },
      bytes);
}

// The same with push constants that are already known.
template <typename Constants>
requires(!std::invocable<Constants, graph::Context&>) void addCompute(const Builder& b, ComputePass pass,
                                                                      const Constants& push) {
  addCompute(b, std::move(pass), [push](graph::Context&) { return push; });
}

// Adds a pass that fills the `cleared` buffers with zeros and discards the contents of the `discarded` ones.
void addClear(const Builder& b, graph::Stage stage, const char* name, const std::vector<graph::BufferId>& cleared,
              const std::vector<graph::BufferId>& discarded = {});

// Adds a pass that fills a small buffer (at most 64 KiB) with values that are known only after the graph has its
// memory: addresses. make(context) returns the values. `of`: the buffers that it refers to, with their uses.
template <typename Make>
graph::BufferId addSmallBuffer(const Builder& b, graph::Stage stage, const char* name, uint64_t bytes,
                               std::vector<graph::Access> of, Make make) {
  const graph::BufferId buffer = b.graph.create(vk::BufferDesc{.size = bytes, .name = name});
  of.emplace_back(buffer, graph::Use::CopyTarget);
  b.graph.pass(stage, name, std::move(of), [=](graph::Context& context) {
    const auto values = make(context);
    const std::span bytes = std::as_bytes(std::span(values));
    vkCmdUpdateBuffer(context.get(), context.buffer(buffer).get(), 0, bytes.size(), bytes.data());
  });
  return buffer;
}

// Returns the size of a dispatch over an image.
inline glm::uvec3 texels(const graph::Graph& graph, graph::ImageId image) {
  const vk::ImageDesc& desc = graph.desc(image);
  return {desc.width, desc.height, desc.layers};
}

}  // namespace latelight::render
