// The sharp end of the prefiltered maps: an equirectangular picture laid out over the octahedron.
#pragma once

#include "scene/environment.h"
#include "scene/picture_io.h"

namespace latelight::scene {

// Fills `map` from `image` (radiance clamped), which is at most twice as wide: a texel then spans at most one and a
// half pixels, which the samples taken cover.
void resampleMirror(const FloatImage& image, HalfImage& map);

}  // namespace latelight::scene
