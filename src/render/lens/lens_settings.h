// What pictures through a lens can have.
#pragma once

#include "render/settings.h"

namespace latelight::render {

// The settings with which a camera that bends rays is rendered: the raster compute, and a layout that keeps positions.
// Throws Error(Usage) for what there is through pinholes alone.
Settings lensSettings(const Settings& settings);

}  // namespace latelight::render
