// Prepares equirectangular pictures for an environment: cleaned, resized, converted to half floats.
#pragma once

#include "scene/environment.h"
#include "scene/picture_io.h"

namespace latelight::scene {

// Radiance from any value in a picture: NaN and negatives become 0, values above the largest half (including infinity)
// that half.
void clampRadiance(FloatImage& image);

// Each pixel of the result is the mean radiance over its part of the sphere: exact box filtering for any pair of sizes,
// rows weighted by their solid angle. Enlarging repeats pixels.
FloatImage resizeEquirectangular(const FloatImage& image, uint32_t width, uint32_t height);

HalfImage toHalf(const FloatImage& image);

// The built-in studio's picture: width twice the height.
FloatImage makeStudio(uint32_t height);

}  // namespace latelight::scene
