// Automatic exposure: the factor for a view's radiance, from the distribution of its luminance.
#pragma once

#include <optional>

#include "output/aov.h"
#include "render/settings/settings.h"

namespace latelight::render {

// The mean luminance becomes this gray (Reinhard et al. 2002, Photographic Tone Reproduction for Digital Images,
// section 3.1: the key of a scene that is neither dark nor bright).
inline constexpr double kMeteredGray = 0.18;
// The mean leaves out this share of the pixels at either end: deep shadows, and lights and their reflections.
inline constexpr double kMeteredTail = 0.1;

// Returns the mean of log2(luminance) over the pixels between the two tails. Pixels count if they have any coverage and
// any light; if none does, the result is empty. `color`: the output of this name (linear, premultiplied). The pixels'
// order does not matter, because the histogram holds integers.
std::optional<double> meanLogLuminance(const output::AovImage& color);

// Returns the settings that a view with these settings is metered with: its linear color, without the sensor and the
// effects that follow exposure, at no more than 512 pixels along a side.
Settings meteringSettings(const Settings& settings, bool hasLens);

}  // namespace latelight::render
