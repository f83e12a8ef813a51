// Structs that the shaders of the instance level of worlds share with the host (world_bvh.h).
#ifndef LATELIGHT_RENDER_RAYS_WORLDS_WORLD_BVH_PUSH_H
#define LATELIGHT_RENDER_RAYS_WORLDS_WORLD_BVH_PUSH_H

#include "shared/lang.h"
#include "shared/rays.h"

SH_BEGIN

SH_CONST uint kWorldBvhGroup = 64u;  // invocations per workgroup; each workgroup processes one world at a time

struct MeshHierarchy {  // of one mesh
  uint64_t nodes;       // RayNode[]; 0: rays do not hit the mesh
  uint64_t triangles;   // RayTriangle[]
};

struct ItemBox {  // of an instance, in the device's world space
  vec3 low, high;
};

struct WorldBvhJob {
  RayScene scene;         // common values
  uint64_t instances;     // Instance[worlds][instanceCount]
  uint64_t meshes;        // MeshHierarchy[]
  uint64_t materials;     // Material[]
  uint64_t keys;          // scratch: uint64_t[worlds][instanceCount]
  uint64_t boxes;         // scratch: ItemBox[worlds][instanceCount]
  uint64_t nodes;         // result: RayNode[worlds][nodeCount]
  uint64_t rayInstances;  // result: RayInstance[worlds][instanceCount]
  uint64_t scenes;        // result: RayScene[worlds]
  // If worlds differ in their emissive surfaces: RayEmitter[worlds][scene.emitterCount] and
  // uint[worlds][instanceCount], results. The lists of `scene` then contain what may emit light in any world.
  uint64_t emitters, emitterIndices;
  uint worlds, instanceCount;
  uint nodeCount;  // maximum per world
  uint padding;
};

struct WorldBvhPush {
  uint64_t job;  // WorldBvhJob
};

SH_END

#endif
