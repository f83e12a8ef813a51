#include "render/post/bloom/bloom.h"

#include <fmt/core.h>

namespace latelight::render {

namespace {

constexpr uint32_t kGroup = 16;  // local_size of the shaders
// Not half floats: some devices cut them off, and a chain of levels would lose a part of the light.
constexpr VkFormat kPictureFormat = VK_FORMAT_R32G32B32A32_SFLOAT;

vk::Pipeline makeDown(vk::Device& device, bool damp) {
  return vk::makePipeline(device, vk::ComputeDesc{.shader = "bloom_down.comp",
                                                  .bindings = {vk::Binding::Sampled, vk::Binding::Storage},
                                                  .constants = {{16, damp ? 1u : 0u}},
                                                  .name = "bloom down"});
}

vk::Pipeline makeJoining(vk::Device& device, const char* shader) {
  return vk::makePipeline(
      device, vk::ComputeDesc{.shader = shader,
                              .bindings = {vk::Binding::Sampled, vk::Binding::Sampled, vk::Binding::Storage},
                              .name = shader});
}

vk::ImageDesc likeButNamed(const vk::ImageDesc& desc, const std::string& name) {
  return {.format = kPictureFormat, .width = desc.width, .height = desc.height, .layers = desc.layers, .name = name};
}

}  // namespace

BloomPass::BloomPass(vk::Device& device)
    : down_(makeDown(device, false)),
      dampedDown_(makeDown(device, true)),
      up_(makeJoining(device, "bloom_up.comp")),
      blend_(makeJoining(device, "bloom_blend.comp")),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

graph::ImageId BloomPass::addDown(graph::Graph& graph, graph::ImageId source, const BloomParameters& parameters,
                                  uint32_t level) const {
  vk::ImageDesc desc = likeButNamed(graph.desc(source), fmt::format("glow {}", level));
  desc.width = (desc.width + 1) / 2;
  desc.height = (desc.height + 1) / 2;
  const graph::ImageId half = graph.create(desc);
  // Only the picture itself has pixels that stand out alone, a scale and a threshold.
  const bool first = level == 1;
  const vk::Pipeline& pipeline = first && parameters.fireflies == kBloomDamp ? dampedDown_ : down_;
  struct {
    float scale, threshold;
  } push{first ? parameters.scale : 1.0f, first ? parameters.threshold : 0.0f};
  graph.pass(graph::Stage::Post, "bloom down", {{source, graph::Use::SampledCompute}, {half, graph::Use::StorageWrite}},
             [=, this, &pipeline](graph::Context& context) {
               context.commands().bind(
                   pipeline, {{context.image(source).arrayView(), sampler_.get()}, {context.image(half).arrayView()}},
                   push);
               context.commands().dispatch(desc.width, desc.height, desc.layers, kGroup, kGroup);
             });
  return half;
}

graph::ImageId BloomPass::addUp(graph::Graph& graph, graph::ImageId fine, graph::ImageId coarse, float radius) const {
  const vk::ImageDesc desc = likeButNamed(graph.desc(fine), graph.desc(fine).name + ", all of it");
  const graph::ImageId joined = graph.create(desc);
  graph.pass(
      graph::Stage::Post, "bloom up",
      {{fine, graph::Use::SampledCompute}, {coarse, graph::Use::SampledCompute}, {joined, graph::Use::StorageWrite}},
      [=, this](graph::Context& context) {
        context.commands().bind(up_,
                                {{context.image(fine).arrayView(), sampler_.get()},
                                 {context.image(coarse).arrayView(), sampler_.get()},
                                 {context.image(joined).arrayView()}},
                                radius);
        context.commands().dispatch(desc.width, desc.height, desc.layers, kGroup, kGroup);
      });
  return joined;
}

graph::ImageId BloomPass::add(graph::Graph& graph, graph::ImageId picture, const BloomParameters& parameters) const {
  // Down to one texel, but for the one that a single texel would give again.
  std::vector<graph::ImageId> levels;
  graph::ImageId finest = picture;
  do {
    finest = addDown(graph, finest, parameters, static_cast<uint32_t>(levels.size()) + 1);
    levels.push_back(finest);
  } while (graph.desc(finest).width > 1 || graph.desc(finest).height > 1);
  graph::ImageId glow = levels.back();
  for (size_t i = levels.size() - 1; i-- > 0;) glow = addUp(graph, levels[i], glow, parameters.radius);

  const vk::ImageDesc desc = likeButNamed(graph.desc(picture), "picture with bloom");
  const graph::ImageId result = graph.create(desc);
  struct {
    float scale, threshold, strength;
  } push{parameters.scale, parameters.threshold, parameters.strength};
  graph.pass(
      graph::Stage::Post, "bloom blend",
      {{picture, graph::Use::SampledCompute}, {glow, graph::Use::SampledCompute}, {result, graph::Use::StorageWrite}},
      [=, this](graph::Context& context) {
        context.commands().bind(blend_,
                                {{context.image(picture).arrayView(), sampler_.get()},
                                 {context.image(glow).arrayView(), sampler_.get()},
                                 {context.image(result).arrayView()}},
                                push);
        context.commands().dispatch(desc.width, desc.height, desc.layers, kGroup, kGroup);
      });
  return result;
}

}  // namespace latelight::render
