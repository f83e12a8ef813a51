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

FrameHistory temporalHistory() {
  return FrameHistory({{kHistoryFormat, "history"}, {kHistoryFormat, "history state"}});
}

graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, FrameHistory& history, bool begins) {
  if (begins) history.begin(f);
  const FrameHistory::Images images = history.advance(f);
  // The history bindings need an image even if a history begins; the shader does not read it then.
  const graph::ImageId oldColor = begins ? sources.picture : images.last[0];
  const graph::ImageId oldState = begins ? sources.picture : images.last[1];
  const graph::ImageId color = images.next[0], state = images.next[1];

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
