// Bloom (docs/post/bloom.md): spreads a share of every pixel's light over its surroundings, by a chain of downsampled
// pictures.
#pragma once

#include "render/pass.h"

namespace latelight::render {

inline constexpr uint32_t kBloomDamp = 0, kBloomKeep = 1;  // numbered as in BloomFireflies

struct BloomParameters {
  float scale = 1;  // of the picture
  float strength = 0, radius = 0, threshold = 0;
  uint32_t fireflies = kBloomDamp;
};

// The linear picture with its glow, R32G32B32A32_SFLOAT, times `scale`.
graph::ImageId addBloom(const Builder& b, graph::ImageId picture, const BloomParameters& parameters);

}  // namespace latelight::render
