#include "render/post/bloom/bloom.h"

#include <fmt/core.h>

#include "render/base/constant_ids.h"
#include "render/post/bloom/bloom_push.h"
#include "render/settings/settings.h"

namespace latelight::render {

static_assert(indexOf(BloomFireflies::Damp) == kBloomDamp);
static_assert(indexOf(BloomFireflies::Keep) == kBloomKeep);

namespace {

// 32-bit floats: some devices truncate to half floats instead of rounding, so a chain of levels would lose light.
constexpr VkFormat kPictureFormat = VK_FORMAT_R32G32B32A32_SFLOAT;

graph::ImageId createPicture(graph::Graph& graph, glm::uvec3 size, const std::string& name) {
  return graph.create(
      vk::ImageDesc{.format = kPictureFormat, .width = size.x, .height = size.y, .layers = size.z, .name = name});
}

graph::ImageId addDown(const Builder& b, graph::ImageId source, const BloomParameters& parameters, uint32_t level) {
  const glm::uvec3 size = (texels(b.graph, source) + glm::uvec3(1, 1, 0)) / glm::uvec3(2, 2, 1);
  const graph::ImageId half = createPicture(b.graph, size, fmt::format("glow {}", level));
  // Fireflies, scale and threshold apply only to the first level, which reads the picture itself.
  const bool first = level == 1;
  const uint32_t damp = first && parameters.fireflies == kBloomDamp ? 1 : 0;
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "bloom down",
              .shader = "bloom_down.comp",
              .bindings = Bindings(b.device).sampled(source).storage(half, graph::Use::StorageWrite),
              .size = size,
              .constants = {{kDampConstant, damp}}},
             shared::BloomDownPush{first ? parameters.scale : 1.0f, first ? parameters.threshold : 0.0f});
  return half;
}

graph::ImageId addUp(const Builder& b, graph::ImageId fine, graph::ImageId coarse, float radius) {
  const glm::uvec3 size = texels(b.graph, fine);
  const graph::ImageId joined = createPicture(b.graph, size, b.graph.desc(fine).name + ", all of it");
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "bloom up",
              .shader = "bloom_up.comp",
              .bindings = Bindings(b.device).sampled(fine).sampled(coarse).storage(joined, graph::Use::StorageWrite),
              .size = size},
             shared::BloomUpPush{radius});
  return joined;
}

}  // namespace

graph::ImageId addBloom(const Builder& b, graph::ImageId picture, const BloomParameters& parameters) {
  // Downsample until one texel is left; further levels would only repeat it.
  std::vector<graph::ImageId> levels;
  graph::ImageId coarsest = picture;
  do {
    coarsest = addDown(b, coarsest, parameters, static_cast<uint32_t>(levels.size()) + 1);
    levels.push_back(coarsest);
  } while (b.graph.desc(coarsest).width > 1 || b.graph.desc(coarsest).height > 1);
  graph::ImageId glow = levels.back();
  for (size_t i = levels.size() - 1; i-- > 0;) glow = addUp(b, levels[i], glow, parameters.radius);

  const glm::uvec3 size = texels(b.graph, picture);
  const graph::ImageId result = createPicture(b.graph, size, "picture with bloom");
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "bloom blend",
              .shader = "bloom_blend.comp",
              .bindings = Bindings(b.device).sampled(picture).sampled(glow).storage(result, graph::Use::StorageWrite),
              .size = size},
             shared::BloomBlendPush{parameters.scale, parameters.threshold, parameters.strength});
  return result;
}

}  // namespace latelight::render
