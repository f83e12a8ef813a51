// How much of the light at a place its surroundings take away. The first picture has neither shadows nor an
// environment, so that corners, the ground under a plinth and the insides of mouldings would look as bright as open
// walls; what dirt and age do to them stands in for it.
#pragma once

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin::hall {

// About the distance in metres from a point of the hall to its nearest wall, column, ceiling or floor; 0 and below
// inside.
float openDistance(vec3 p);

// Shade of a mesh whose points are moved by `offset` into the hall: of all its copies, those with the same
// surroundings.
Shade shadeInHall(vec3 offset = vec3(0));

}  // namespace latelight::scene::builtin::hall
