// The render targets of a G-buffer as pictures, as stored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "output/debug.h"

namespace latelight::output {

enum class TargetKind {
  Unorm,  // shown as it is
  Srgb,   // decoded to linear, as shaders read it; shown by its codes
  Float,
  Light,  // linear radiance: clamped to 1, sRGB-encoded
  Words,  // integers of 32 bits
};

struct RawTarget {
  std::string name;
  std::string channels;  // "rgb: diffuse color; a: power": what is in each channel, by its letters
  TargetKind kind;
  uint32_t count;               // channels per texel
  std::vector<float> values;    // 4 per pixel, as shaders read them; empty for Words
  std::vector<uint32_t> words;  // 4 per pixel; only for Words
};

struct RawGbuffer {
  uint32_t width = 0, height = 0;
  std::vector<RawTarget> targets;
  std::vector<float> depth;  // metres along the view axis, +inf for background
};

// Each target's colour channels as one picture and its alpha, where it is used, as another, then the depth; labelled
// with target, channels and contents. Floats in [-1, 1] are shown as x * 0.5 + 0.5, those in [0, 1] sRGB-encoded (alpha
// as it is), others stretched over the range present, on a logarithmic scale where that spans three decades, as the
// label says. An integer "id" is shown in the colours of debugPicture(), other words as their low three bytes and their
// high one.
std::vector<Labelled> targetPictures(const RawGbuffer& gbuffer);

}  // namespace latelight::output
