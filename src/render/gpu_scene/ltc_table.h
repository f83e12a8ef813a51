// The fitted lobes of shared/area_light.h, as scripts/fit_ltc.py wrote them.
#pragma once

#include <span>

#include "shared/area_light.h"

namespace latelight::render {

// kLtcSize rows of perceptual roughness, from 0 to 1, with kLtcSize columns of sqrt(1 - n.v), from 0 to 1.
std::span<const shared::LtcFit> ltcTable();

// Returns the bilinear interpolation, as shaders compute it (render/glsl/area_lights.glsl).
shared::LtcFit lobeFit(float nv, float roughness);

}  // namespace latelight::render
