// Sepia toning: an example of a post-processing effect.
#pragma once

#include "render/base/pass.h"

namespace latelight::render {

// `strength`: 0 to 1.
graph::ImageId addSepia(const Builder& b, graph::ImageId picture, float strength);

}  // namespace latelight::render
