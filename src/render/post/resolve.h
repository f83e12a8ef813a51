// Passes from lit frames to the finished picture: accumulation of jittered frames, then tone mapping to 8 bits.
#pragma once

#include <glm/vec4.hpp>

#include "render/base/pass.h"
#include "render/base/readback.h"
#include "render/post/compose_push.h"

namespace latelight::render {

// Computes sum = (first ? 0 : sum) + frame, for the jittered frames of one picture. `sum` is R32G32B32A32_SFLOAT and
// has the size of `frame`.
void addAccumulate(const Builder& b, graph::ImageId frame, graph::ImageId sum, bool first);

struct ComposeSettings {
  float scale = 1;          // factor for the picture: 1 / number of accumulated frames
  uint32_t tonemap = 0;     // kTonemap*
  graph::BufferId covered;  // tiles outside of which the picture is 0 (frame/covered_tiles.h); null: unknown
  glm::vec4 background{0};  // linear display color; alpha 0: transparent
};
// `pixels` is the address of the first view's pixels, and `viewBytes` the stride to those of the next view.
shared::ComposePush composePush(const ComposeSettings& settings, VkDeviceAddress pixels, uint64_t viewBytes);

// Writes the finished picture: RGBA8, sRGB, straight alpha.
void addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultTarget& to);
// Adds a pass that writes the finished picture with the shader `name`.comp, which must write it with writeCode() of
// compose.glsl.
void addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture, const ComposeSettings& settings,
                  const ResultTarget& to);
// The constant of displayColor().
inline vk::Constant tonemapConstant(const ComposeSettings& settings) {
  return {kTonemapConstant, settings.tonemap};
}

}  // namespace latelight::render
