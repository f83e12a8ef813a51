// Push constants of ray_refit.comp.
#ifndef LATELIGHT_RENDER_RAYS_REFIT_PUSH_H
#define LATELIGHT_RENDER_RAYS_REFIT_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct RayRefitPush {
  uint64_t meshes;     // Mesh[]
  uint64_t nodes;      // RayNode[nodeCount] of one mesh; with worlds, [worlds][nodeCount]
  uint64_t triangles;  // RayTriangle[]
  uint mesh;
  uint nodeCount;
  uint meshStride;  // records from the mesh of a world to that of the next one
  uint padding;
};

SH_END

#endif
