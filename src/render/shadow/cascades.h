// Cascades: spheres along a view that its directional lights' shadow maps are fitted around, finest first.
#pragma once

#include <vector>

#include "render/frustum.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

inline constexpr uint32_t kCascades = 4;

// The part of the view that the scene takes up, cut across into slices, each kCascadeRatio times as far as the one
// before, and the smallest sphere around each (Valient 2008, Stable Rendering of Cascaded Shadow Maps, ShaderX6): its
// radius doesn't change as the view turns or moves. Where the scene's own sphere is smaller, that one is used and is
// the last. The distances are rounded outwards to steps of a quarter of an octave, so that a moving view mostly keeps
// them. Empty where no part of the scene can be in the view.
inline constexpr double kCascadeRatio = 3;
std::vector<Sphere> fitCascades(const shared::View& view, const scene::Bounds& bounds);

}  // namespace latelight::render
