// The share of light at a point that its surroundings occlude. The default picture has few shadows and no environment,
// so corners, the ground under a plinth and the insides of mouldings would look as bright as open walls; baked
// occlusion, like dirt and age, stands in for that.
#pragma once

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin::hall {

// About the distance in metres from a point of the hall to its nearest wall, column, ceiling or floor; 0 and below
// inside.
float openDistance(vec3 p);

// Shade of a mesh whose points are moved by `offset` into the hall, for all its copies with the same surroundings.
Shade shadeInHall(vec3 offset = vec3(0));

}  // namespace latelight::scene::builtin::hall
