#include "render/post/post.h"

#include "render/post/bloom/bloom.h"
#include "render/post/fxaa/fxaa.h"
#include "render/post/resolve.h"
#include "render/registry.h"

namespace latelight::render {

namespace {

template <typename Pass>
Pass& made(std::unique_ptr<Pass>& pass, vk::Device& device) {
  if (!pass) pass = std::make_unique<Pass>(device);
  return *pass;
}

BloomParameters bloomParameters(const BloomSettings& s, float scale) {
  return {.scale = scale,
          .strength = s.strength,
          .radius = s.radius,
          .threshold = s.threshold,
          .fireflies = indexByName(bloomFireflies(), s.fireflies, "treatment of fireflies")};
}

ComposeSettings composeSettings(const Settings& s, float scale) {
  return {.scale = scale,
          .tonemap = indexByName(tonemaps(), s.tonemap, "tonemap"),
          .background = glm::vec4(s.backgroundColor, s.background == Background::Color ? 1.0f : 0.0f)};
}

}  // namespace

PostChain::PostChain(vk::Device& device)
    : device_(device),
      accumulate_(std::make_unique<AccumulatePass>(device)),
      compose_(std::make_unique<ComposePass>(device)) {}

PostChain::~PostChain() = default;

void PostChain::accumulate(graph::Graph& graph, graph::ImageId frame, graph::ImageId sum, bool first) const {
  accumulate_->add(graph, frame, sum, first);
}

FinishedPicture PostChain::add(graph::Graph& graph, graph::ImageId picture, float scale, const Settings& s) {
  FinishedPicture result{.linear = picture, .scale = scale};
  if (s.bloom.strength > 0) {
    result.linear = made(bloom_, device_).add(graph, picture, bloomParameters(s.bloom, scale));
    result.scale = 1;
  }
  if (!s.display) return result;
  const ComposeSettings compose = composeSettings(s, result.scale);
  result.display =
      s.fxaa ? made(fxaa_, device_).add(graph, result.linear, compose) : compose_->add(graph, result.linear, compose);
  return result;
}

}  // namespace latelight::render
