#include "render/post/taa/taa.h"

namespace latelight::render {

namespace {

constexpr uint32_t kGroup = 16;                                   // local_size of taa.comp
constexpr VkFormat kColorFormat = VK_FORMAT_R32G32B32A32_SFLOAT;  // halves would lose what one of 64 samples adds
constexpr VkFormat kStateFormat = VK_FORMAT_R32G32B32A32_SFLOAT;

// The digits of `index` in that base, behind the point in reverse order.
float radicalInverse(uint32_t index, uint32_t base) {
  float value = 0, place = 1;
  for (; index > 0; index /= base) {
    place /= static_cast<float>(base);
    value += place * static_cast<float>(index % base);
  }
  return value;
}

vk::Image makeHistory(vk::Device& device, const FrameInputs& inputs, VkFormat format, const char* name) {
  return vk::Image(device,
                   {.format = format,
                    .width = inputs.width,
                    .height = inputs.height,
                    .layers = static_cast<uint32_t>(inputs.views.size()),
                    .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                    .name = name});
}

}  // namespace

const std::vector<glm::vec2>& temporalJitters() {
  static const std::vector<glm::vec2> jitters = [] {
    std::vector<glm::vec2> all;
    glm::vec2 sum(0);
    for (uint32_t i = 1; i <= kTemporalSamples; ++i) {
      all.emplace_back(radicalInverse(i, 2), radicalInverse(i, 3));
      sum += all.back();
    }
    for (glm::vec2& jitter : all) jitter -= sum / static_cast<float>(kTemporalSamples);
    return all;
  }();
  return jitters;
}

bool TemporalHistory::fits(uint32_t width, uint32_t height, size_t views) const {
  if (!filled_) return false;
  const vk::ImageDesc& desc = color_[0].desc();
  return desc.width == width && desc.height == height && desc.layers == views;
}

TemporalPass::TemporalPass(vk::Device& device)
    : device_(device),
      pipeline_(vk::makePipeline(
          device, vk::ComputeDesc{.shader = "taa.comp",
                                  .bindings = {vk::Binding::Sampled, vk::Binding::Sampled, vk::Binding::Sampled,
                                               vk::Binding::Sampled, vk::Binding::Sampled, vk::Binding::Storage,
                                               vk::Binding::Storage},
                                  .name = "temporal"})),
      nearest_(vk::makeSampler(device, vk::kNearestSampler)),
      linear_(vk::makeSampler(device, {.mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                       .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                       .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE})) {}

graph::ImageId TemporalPass::begin(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources,
                                   TemporalHistory& history) const {
  if (!history.fits(inputs.width, inputs.height, inputs.views.size())) {
    for (int i = 0; i < 2; ++i) {
      history.color_[i] = makeHistory(device_, inputs, kColorFormat, "history");
      history.state_[i] = makeHistory(device_, inputs, kStateFormat, "history state");
    }
  }
  history.filled_ = true;
  history.frames_ = 0;
  return add(graph, inputs, sources, {}, history);
}

graph::ImageId TemporalPass::resume(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources,
                                    TemporalHistory& history) const {
  const uint32_t old = history.newest_;
  return add(graph, inputs, sources,
             {graph.import(history.color_[old], graph::Use::SampledCompute),
              graph.import(history.state_[old], graph::Use::SampledCompute)},
             history);
}

graph::ImageId TemporalPass::add(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources, const Old& old,
                                 TemporalHistory& history) const {
  const bool begins = !old.color;
  const uint32_t target = 1 - history.newest_;
  const graph::ImageId color = graph.import(history.color_[target], std::nullopt);
  const graph::ImageId state = graph.import(history.state_[target], std::nullopt);
  graph.exports(color, graph::Use::SampledCompute);
  graph.exports(state, graph::Use::SampledCompute);
  history.newest_ = target;
  ++history.frames_;

  std::vector<graph::Access> accesses{{sources.picture, graph::Use::SampledCompute},
                                      {sources.depth, graph::Use::SampledCompute},
                                      {sources.motion, graph::Use::SampledCompute}};
  if (!begins) accesses.emplace_back(old.color, graph::Use::SampledCompute);
  if (!begins) accesses.emplace_back(old.state, graph::Use::SampledCompute);
  accesses.emplace_back(color, graph::Use::StorageWrite);
  accesses.emplace_back(state, graph::Use::StorageWrite);
  const float samples = begins ? static_cast<float>(kTemporalSamples) : 0.0f;
  graph.pass(graph::Stage::Post, "temporal", std::move(accesses), [=, this](graph::Context& context) {
    struct {
      VkDeviceAddress frame;
      float scale, samples;
    } push{inputs.constants, samples > 0 ? 1 / samples : 1.0f, samples};
    // Something must be bound for the old ones; where a history begins, it is not read.
    std::vector<vk::BoundImage> images;
    for (graph::ImageId image : {sources.picture, sources.depth, sources.motion, begins ? sources.picture : old.color,
                                 begins ? sources.picture : old.state})
      images.push_back({context.image(image).arrayView(), image == old.color ? linear_.get() : nearest_.get()});
    images.push_back({context.image(color).arrayView()});
    images.push_back({context.image(state).arrayView()});
    context.commands().bind(pipeline_, images, push);
    context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), kGroup,
                                kGroup);
  });
  return color;
}

}  // namespace latelight::render
