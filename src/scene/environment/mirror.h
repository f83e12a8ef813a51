// The mirror (roughness 0) level of the prefiltered maps: an equirectangular image resampled to an octahedral map.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// Fills `map` from `image`, whose radiance is clamped and whose width is at most twice the map's. A texel then covers
// at most one and a half pixels, within the footprint of the samples.
void resampleMirror(const FloatImage& image, FloatImage& map);

}  // namespace latelight::scene
