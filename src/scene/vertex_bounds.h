// The exact bounds of a scene, for users: worldBounds() is faster, and larger if instances are rotated.
#pragma once

#include "scene/scene.h"

namespace latelight::scene {

// Returns the smallest box in world space that contains the vertices of all visible instances at rest. Most instances
// need no look at their vertices: those whose transform keeps boxes parallel to the axes, and those whose transformed
// box lies within the bounds of others.
Bounds vertexBounds(const Scene& scene);

}  // namespace latelight::scene
