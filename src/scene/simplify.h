// Simplifies the meshes of a scene to a given number of triangles.
#pragma once

#include "scene/scene.h"

namespace latelight::scene {

// Simplifies every mesh so that all instances together have about `triangles`, or as close above that as one triangle
// per mesh allows. Does nothing if the scene has at most that many. Shapes become coarse and may break apart: the
// result is for measuring, not for viewing. (meshoptimizer's simplification by vertex clustering.)
void simplify(Scene& scene, uint64_t triangles);

}  // namespace latelight::scene
