// Checks whether a scene has what settings refer to.
#pragma once

#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::render {

// Throws Error(Usage) if the background shows the environment, but there is none.
void checkBackground(const Settings& settings, bool hasEnvironment);

// Throws Error(Usage) if shadows are rendered and --shadow-lights names a light that neither the scene nor --sun has. A
// scene without any light accepts all names.
void checkShadowLightsOf(const scene::Scene& scene, const Settings& settings);

}  // namespace latelight::render
