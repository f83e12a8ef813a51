// The render targets of a G-buffer made visible, as they are stored.
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
  Light,  // linear radiance: clamped to 1, sRGB-coded
  Words,  // integers of 32 bits
};

struct RawTarget {
  std::string name;
  std::string channels;  // "rgb: diffuse colour; a: power": what is in each channel, by its letters
  TargetKind kind;
  uint32_t count;               // channels a texel
  std::vector<float> values;    // 4 a pixel, as shaders read them; empty for Words
  std::vector<uint32_t> words;  // 4 a pixel; only for Words
};

struct RawGbuffer {
  uint32_t width = 0, height = 0;
  std::vector<RawTarget> targets;
  std::vector<float> depth;  // metres along the view axis, +inf where nothing is
};

// Each target's colour channels as one picture and its alpha, where that has a use, as another, then the depth;
// labelled with target, channels and what they hold. Floats of [-1, 1] are shown as x * 0.5 + 0.5, those of [0, 1]
// sRGB-coded (alpha as it is), others stretched over the range present, on a logarithmic scale where that spans three
// decades: the label says so. Of integers an "id" is shown in the colours of debugPicture(), other words as their low
// three bytes and their high one.
std::vector<Labelled> targetPictures(const RawGbuffer& gbuffer);

}  // namespace latelight::output
