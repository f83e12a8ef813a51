// Coarser copies of scenes.
#pragma once

#include "scene/scene.h"

namespace latelight::scene {

// Simplifies every mesh so that all instances together have about `triangles`, or as close above that as one triangle
// per mesh allows; does nothing where the scene has no more. Shapes become coarse and may break apart: for measuring,
// not for viewing. (meshoptimizer's simplification by vertex clustering.)
void simplify(Scene& scene, uint64_t triangles);

}  // namespace latelight::scene
