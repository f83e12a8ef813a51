// Cascaded shadow maps: the bounding spheres, along a view, to which the shadow maps of its directional lights are
// fitted.
#pragma once

#include <vector>

#include "render/base/frustum.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

inline constexpr uint32_t kCascades = 4;

// Stable cascades (Valient 2008, Stable Rendering of Cascaded Shadow Maps, ShaderX6). The part of the view that
// contains the scene is split into up to kCascades slices, each reaching kCascadeRatio times as far as the previous
// one. The result is the smallest sphere around each slice, nearest first; its radius does not change as the view turns
// or moves. If the scene's bounding sphere is smaller, it is used instead and is the last cascade. Distances are
// rounded outward to steps of a quarter of an octave, so they mostly stay the same in a moving view. The result is
// empty if no part of the scene can be in the view.
inline constexpr double kCascadeRatio = 3;
std::vector<Sphere> fitCascades(const shared::View& view, const scene::Bounds& bounds);
double cascadeShare(uint32_t cascade);  // the distance to which a cascade reaches, as a share of the last one's

}  // namespace latelight::render
