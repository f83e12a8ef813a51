// Converts an image to an environment's prefiltered maps, without files or cache.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// Filters an equirectangular image of any size whose values clampRadiance() has cleaned. The result is byte-identical
// for any number of threads.
Environment filterEnvironment(FloatImage picture);

}  // namespace latelight::scene
