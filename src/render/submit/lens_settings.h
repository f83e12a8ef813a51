// The settings that cameras with a lens support.
#pragma once

#include "render/settings/settings.h"

namespace latelight::render {

// Returns the settings with which a camera that bends rays is rendered: the raster compute, and a layout that stores
// positions. Throws Error(Usage) for settings that require a pinhole or orthographic camera.
Settings lensSettings(const Settings& settings);

}  // namespace latelight::render
