#include "render/post/taa/taa.h"

#include "render/post/taa/temporal_push.h"

namespace latelight::render {

namespace {

// With half floats, the contribution of one of 64 samples to the color would be lost.
constexpr VkFormat kHistoryFormat = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr vk::SamplerDesc kHistorySampler{.mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                          .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                          .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};

// The radical inverse: the digits of `index` in this base, mirrored at the radix point.
float radicalInverse(uint32_t index, uint32_t base) {
  float value = 0, place = 1;
  for (; index > 0; index /= base) {
    place /= static_cast<float>(base);
    value += place * static_cast<float>(index % base);
  }
  return value;
}

vk::Image makeHistory(const FrameContext& f, const char* name) {
  return vk::Image(f.device,
                   {.format = kHistoryFormat,
                    .width = f.width,
                    .height = f.height,
                    .layers = f.viewCount(),
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

void TemporalHistory::begin(const FrameContext& f) {
  if (!fits(f.width, f.height, f.viewCount())) {
    for (int i = 0; i < 2; ++i) {
      color_[i] = makeHistory(f, "history");
      state_[i] = makeHistory(f, "history state");
    }
  }
  filled_ = true;
  frames_ = 0;
}

graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, TemporalHistory& history,
                           bool begins) {
  if (begins) history.begin(f);
  // The history bindings need an image even if a history begins; the shader does not read it then.
  graph::ImageId oldColor = sources.picture, oldState = sources.picture;
  if (!begins) {
    oldColor = f.graph.import(history.color_[history.newest_], graph::Use::SampledCompute);
    oldState = f.graph.import(history.state_[history.newest_], graph::Use::SampledCompute);
  }
  history.newest_ = 1 - history.newest_;
  ++history.frames_;
  const graph::ImageId color = f.graph.import(history.color_[history.newest_], std::nullopt);
  const graph::ImageId state = f.graph.import(history.state_[history.newest_], std::nullopt);
  f.graph.exports(color, graph::Use::SampledCompute);
  f.graph.exports(state, graph::Use::SampledCompute);

  const float samples = begins ? static_cast<float>(kTemporalSamples) : 0.0f;
  addCompute(f,
             {.stage = graph::Stage::Post,
              .name = "temporal",
              .shader = "taa.comp",
              .bindings = Bindings(f.device)
                              .sampled({sources.picture, sources.depth, sources.motion})
                              .sampled(oldColor, kHistorySampler)
                              .sampled(oldState)
                              .storage(color, graph::Use::StorageWrite)
                              .storage(state, graph::Use::StorageWrite),
              .size = f.pixels()},
             shared::TemporalPush{f.constants, begins ? 1 / samples : 1.0f, samples});
  return color;
}

}  // namespace latelight::render
