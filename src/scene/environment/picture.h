// Prepares equirectangular pictures for an environment: cleaned and resized.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// The largest radiance that is kept, some 600 times the luminance of the sun in cd/m2. Sums in doubles over a row that
// contains it still resolve 1e-4.
inline constexpr float kMaxRadiance = 1e12f;

// Radiance from any value in a picture: NaN and negatives become 0, larger values kMaxRadiance. Infinity becomes the
// largest half: it is what files of half floats contain where their writer exceeded that.
void clampRadiance(FloatImage& image);

// Each pixel of the result is the mean radiance over its part of the sphere: exact box filtering for any pair of sizes,
// rows weighted by their solid angle. Enlarging repeats pixels.
FloatImage resizeEquirectangular(const FloatImage& image, uint32_t width, uint32_t height);

// The built-in studio's picture: width twice the height.
FloatImage makeStudio(uint32_t height);

}  // namespace latelight::scene
