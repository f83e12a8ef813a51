// Falloff of the light that reaches the sensor, from the axis to the corners.
#pragma once

#include <vector>

#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::render {

// Multiplies the colors of an RGBA picture by Settings::vignetting. An orthographic camera and a panorama have no axis,
// so that cos4 does not change them.
void darken(std::vector<float>& rgba, const Settings& settings, const scene::Camera& camera);

}  // namespace latelight::render
