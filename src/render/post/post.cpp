#include "render/post/post.h"

#include "render/post/bloom/bloom.h"
#include "render/post/fxaa/fxaa.h"
#include "render/post/resolve.h"

namespace latelight::render {

namespace {

BloomParameters bloomParameters(const Settings& s, float scale) {
  return {.scale = scale,
          .strength = s.bloom,
          .radius = s.bloomRadius,
          .threshold = s.bloomThreshold,
          .fireflies = indexOf(s.bloomFireflies)};
}

ComposeSettings composeSettings(const Settings& s, float scale) {
  return {.scale = scale,
          .tonemap = indexOf(s.tonemap),
          .background = glm::vec4(s.background.color, s.background.kind == Background::Color ? 1.0f : 0.0f)};
}

}  // namespace

FinishedPicture finishPicture(const Builder& b, graph::ImageId picture, float scale, const Settings& settings,
                              const std::optional<ResultTarget>& display, graph::BufferId covered) {
  FinishedPicture result{.linear = picture, .scale = scale};
  if (settings.bloom > 0) {
    result.linear = addBloom(b, picture, bloomParameters(settings, scale));
    result.scale = 1;
  }
  if (!display) return result;
  ComposeSettings compose = composeSettings(settings, result.scale);
  if (result.linear == picture) compose.covered = covered;
  if (settings.aa.fxaa)
    addFxaa(b, result.linear, compose, *display);
  else
    addCompose(b, result.linear, compose, *display);
  return result;
}

}  // namespace latelight::render
