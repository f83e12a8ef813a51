// The sharp end of the prefiltered maps: an equirectangular picture resampled to an octahedral map.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// Fills `map` from `image` (radiance clamped), which is at most twice as wide: a texel then covers at most one and a
// half pixels, within the footprint of the samples taken.
void resampleMirror(const FloatImage& image, FloatImage& map);

}  // namespace latelight::scene
