// Equirectangular pictures on their way into an environment: cleaned, resized, made halves.
#pragma once

#include "scene/environment.h"
#include "scene/picture_io.h"

namespace latelight::scene {

// Radiance of what a picture may hold: NaN and negatives become 0, what is above the largest half (infinity too) that
// half.
void clampRadiance(FloatImage& image);

// Each pixel of the result is the mean radiance over its part of the sphere: exact box filtering for any pair of sizes,
// rows weighed by their solid angle. Works both ways: enlarging repeats pixels.
FloatImage resizeEquirectangular(const FloatImage& image, uint32_t width, uint32_t height);

HalfImage toHalf(const FloatImage& image);

// The built-in studio's picture: width twice the height.
FloatImage makeStudio(uint32_t height);

}  // namespace latelight::scene
