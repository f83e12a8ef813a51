// Coarser copies of scenes.
#pragma once

#include "scene/scene.h"

namespace latelight::scene {

// Simplifies every mesh so that all instances together have about `triangles`, or as few above that as one triangle a
// mesh leaves; nothing where the scene has no more. Shapes get coarse and may come apart: for measuring, not for
// looking at. (meshoptimizer's simplification by vertex clustering.)
void simplify(Scene& scene, uint64_t triangles);

}  // namespace latelight::scene
