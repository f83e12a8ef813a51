// Bloom (docs/post/bloom.md; Jimenez 2014, Next Generation Post Processing in Call of Duty: Advanced Warfare, SIGGRAPH
// course Advances in Real-Time Rendering): spreads a fraction of every pixel's light over its surroundings. The picture
// is downsampled level by level to one texel ("glow 1", "glow 2", ...), the levels are upsampled and mixed from coarse
// to fine, and the result is blended with the picture.
#pragma once

#include "render/base/pass.h"

namespace latelight::render {

inline constexpr uint32_t kBloomDamp = 0, kBloomKeep = 1;  // numbered as in BloomFireflies

struct BloomParameters {
  float scale = 1;  // factor for the picture
  float strength = 0, radius = 0, threshold = 0;
  uint32_t fireflies = kBloomDamp;
};

// Returns the linear picture with bloom, multiplied by `scale`, in R32G32B32A32_SFLOAT.
graph::ImageId addBloom(const Builder& b, graph::ImageId picture, const BloomParameters& parameters);

}  // namespace latelight::render
