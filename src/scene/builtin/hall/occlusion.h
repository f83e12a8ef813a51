// Baked ambient occlusion: the fraction of light at a point that its surroundings block. The default view has few
// shadows and no environment, so without it corners, the ground under a plinth and the insides of moldings would look
// as bright as open walls. It also stands in for dirt and age.
#pragma once

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin::hall {

// Signed distance function of the hall: returns the approximate distance in meters from a point to its nearest wall,
// column, ceiling or floor, which is at most 0 inside them.
float openDistance(vec3 p);

// Returns the Shade of a mesh whose points `offset` moves into the hall, for all its copies with the same surroundings.
Shade shadeInHall(vec3 offset = vec3(0));

}  // namespace latelight::scene::builtin::hall
