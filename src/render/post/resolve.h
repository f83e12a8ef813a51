// From lit frames to the finished picture: accumulation of jittered frames, then tonemapping to 8 bits.
#pragma once

#include <glm/vec4.hpp>

#include "render/pass.h"
#include "render/post/compose_push.h"
#include "render/readback.h"

namespace latelight::render {

// sum = (first ? 0 : sum) + frame: jittered frames of one picture. `sum` is R32G32B32A32_SFLOAT, as large as `frame`.
void addAccumulate(const Builder& b, graph::ImageId frame, graph::ImageId sum, bool first);

struct ComposeSettings {
  float scale = 1;          // of the picture: 1 / number of accumulated frames
  uint32_t tonemap = 0;     // kTonemap*
  glm::vec4 background{0};  // linear display colour; alpha 0: transparent
};
// `pixels`: where the first view's lie, and from there `viewBytes` to the next one's.
shared::ComposePush composePush(const ComposeSettings& settings, VkDeviceAddress pixels, uint64_t viewBytes);

// The finished picture: RGBA8, sRGB, straight alpha.
void addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultPlace& to);
// Adds the pass that writes it, by the shader `name`.comp, which writes as compose.glsl does.
void addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture, const ComposeSettings& settings,
                  const ResultPlace& to);

}  // namespace latelight::render
