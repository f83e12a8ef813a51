// Debug images of a G-buffer's render targets, as stored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "output/debug.h"

namespace latelight::output {

enum class TargetKind {
  Unorm,  // shown unchanged
  Srgb,   // decoded to linear when shaders read it; shown as its codes
  Float,
  Light,  // linear radiance: clamped to 1, sRGB-encoded
  Words,  // 32-bit integers
};

struct RawTarget {
  std::string name;
  std::string channels;  // "rgb: diffuse color; a: power": the contents of each channel, by its letters
  TargetKind kind;
  uint32_t count;               // channels per texel
  std::vector<float> values;    // 4 per pixel, as shaders read them; empty for Words
  std::vector<uint32_t> words;  // 4 per pixel; only for Words
};

struct RawGbuffer {
  uint32_t width = 0, height = 0;
  std::vector<RawTarget> targets;
  std::vector<float> depth;  // meters along the view axis, +inf for background
};

// Returns, for each target, one image of its color channels and, if alpha is used, another of its alpha, then the
// depth. Labels name the target, its channels and their contents. Floats in [-1, 1] are shown as x * 0.5 + 0.5, and
// floats in [0, 1] are sRGB-encoded (alpha unchanged). Other floats are stretched over the range present, on a
// logarithmic scale if it spans three decades; the label states this. An integer "id" is shown in the colors of
// debugPicture(), other words as their low three bytes and their high byte.
std::vector<Labelled> targetPictures(const RawGbuffer& gbuffer);

}  // namespace latelight::output
