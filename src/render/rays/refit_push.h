// Push constants of ray_refit.comp.
#ifndef LATELIGHT_RENDER_RAYS_REFIT_PUSH_H
#define LATELIGHT_RENDER_RAYS_REFIT_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct RayRefitPush {
  uint64_t meshes;     // Mesh[]
  uint64_t nodes;      // RayNode[] of one mesh
  uint64_t triangles;  // RayTriangle[]
  uint mesh;
  uint nodeCount;
};

SH_END

#endif
