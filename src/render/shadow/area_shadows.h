// Shadows of area lights by rays.
#pragma once

#include "render/frame/frame.h"
#include "render/settings/settings.h"

namespace latelight::render {

// Returns the area lights whose shadows rays find, as FrameConstants::areaShadows: those that cast shadows, if
// --shadows is rays and --shadow-lights does not exclude them.
glm::uvec2 areaShadowsOf(const LightSet& lights, const Settings& settings);

// Adds to the lit picture the light of these lights, which the lighting technique leaves out.
void addAreaShadows(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
