// Prepares equirectangular images for an environment: clamps and resizes them.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// The maximum radiance, some 600 times the luminance of the sun in cd/m2. Sums in doubles over a row that contains it
// still resolve 1e-4.
inline constexpr float kMaxRadiance = 1e12f;

// Converts any values in an image to valid radiance: NaN and negative values become 0, values above kMaxRadiance are
// clamped to it. Infinity becomes the largest half, because half-float files contain it for values that exceeded that.
void clampRadiance(FloatImage& image);

// Resizes by exact box filtering for any pair of sizes: each pixel of the result is the mean radiance over its part of
// the sphere, with rows weighted by their solid angle. Enlarging repeats pixels.
FloatImage resizeEquirectangular(const FloatImage& image, uint32_t width, uint32_t height);

// Returns the built-in studio's image, which is twice as wide as high.
FloatImage makeStudio(uint32_t height);

}  // namespace latelight::scene
