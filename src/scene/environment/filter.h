// From a picture to an environment, without files or cache.
#pragma once

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

// Filters an equirectangular picture of any size, its values cleaned by clampRadiance(). The same bytes for any number
// of threads.
Environment filterEnvironment(FloatImage picture);

}  // namespace latelight::scene
