// The bounding volume hierarchies (BVHs) that rays traverse, in device memory (render/rays): one over the triangles of
// each mesh, in object space, and one over the instances of the scene, in world space.
#ifndef LATELIGHT_SHARED_RAYS_H
#define LATELIGHT_SHARED_RAYS_H
#include "shared/types.h"

SH_BEGIN

// A node holds the boxes of both its children, so that one load decides which of them a ray visits (Aila and Laine
// 2009, Understanding the Efficiency of Ray Traversal on GPUs). Node 0 is the root, and children follow their parents.
struct RayNode {
  vec3 lowA;
  uint a;  // kRayLeaf, the number of items - 1, and the first item; or the index of a node
  vec3 highA;
  uint b;  // likewise; kRayNone: there is no second child
  vec3 lowB;
  uint parent;  // index of a node; kRayNone for the root
  vec3 highB;
  uint refitted;  // number of children whose boxes are refitted, during a refit; otherwise 0
};
SH_CONST uint kRayNodeBytes = 64u;
SH_CONST uint kRayLeaf = 0x80000000u;
SH_CONST uint kRayCountShift = 28u;  // three bits: number of items - 1
SH_CONST uint kRayFirstMask = 0x0fffffffu;
SH_CONST uint kRayNone = 0xffffffffu;
SH_CONST uint kMaxRayLeaf = 4u;      // items per leaf
SH_CONST float kRayNodeCost = 1.0f;  // of visiting a node, relative to that of an item

// Maximum number of inner nodes on a path from the root, in the BVH of the instances and in that of a mesh. Together
// with a marker between them they bound the stack of a traversal.
SH_CONST uint kMaxInstanceDepth = 27u;
SH_CONST uint kMaxMeshDepth = 44u;
SH_CONST uint kRayStack = 72u;

struct RayTriangle {  // in the order of the leaves
  uint corners[3];    // vertices of the mesh
  uint number;        // index of the triangle in the mesh
};

// A placement of a mesh, in the order of the leaves.
struct RayInstance {  // 80 bytes
  // Rows of the linear transform from world to object space. w: the slack of boxes along this axis of object space, per
  // meter of distance, which covers the rounding of the transform.
  vec4 rows[3];
  uint64_t nodes;      // RayNode[] of the mesh
  uint64_t triangles;  // RayTriangle[]
  float reach;         // meters: maximum distance of the mesh from the origin of its object space, in world space
  uint instance;       // index in FrameConstants::instances
  uint flags;          // kRay*
  uint padding;
};
SH_CONST uint kRayInstanceBytes = 80u;
SH_CONST uint kRayDoubleSided = 1u;
SH_CONST uint kRayAlphaTested = 2u;     // masked or blended: the texture or the vertex colors decide if a ray passes
SH_CONST uint kRayTranslucent = 4u;     // blended or transmissive
SH_CONST uint kRayClockwise = 8u;       // front faces are clockwise
SH_CONST uint kRayAlphaConstant = 16u;  // masked or blended: the material's own alpha decides

// kRayAlpha* of an instance. Surfaces with one alpha need no texture coordinates. Also, an H200 hung where the same
// code tested textured and untextured surfaces of a scene (docs/experiments.md).
SH_FUNC uint rayAlphaFlags(uint materialFlags, uint textures, uint instanceFlags) {
  if ((materialFlags & (kMaterialMasked | kMaterialBlended)) == 0u) return 0u;
  bool varies = (textures & (1u << kTextureBaseColor)) != 0u || (instanceFlags & kInstanceExtras) != 0u;
  return varies ? kRayAlphaTested : kRayAlphaConstant;
}

// The surfaces that a ray hits.
SH_CONST uint kRayTwoSided = 1u;     // back faces of single-sided materials, too
SH_CONST uint kRayAnySurface = 2u;   // blended and transmissive surfaces, too
SH_CONST uint kRayStopAtFirst = 4u;  // any hit: only isHit() is valid
SH_CONST uint kRayGroupShift = 8u;   // from this bit on: the group whose instances it hits; 0: all instances

SH_CONST uint kRaySceneBytes = 48u;
struct RayScene {
  uint64_t nodes;      // RayNode[] over the instances
  uint64_t instances;  // RayInstance[]
  // A table of kEnvironmentTableBytes per environment that views have; 0: rays do not sample them
  uint64_t environment;
  uint64_t emitters;  // RayEmitter[emitterCount]
  // Per element of FrameConstants::instances, the index of its first emitter, or kRayNone. The emitters of an instance
  // have the order of the mesh's triangles.
  uint64_t emitterIndices;
  uint instanceCount;  // 0: there is nothing to hit, and no node
  uint emitterCount;
};

// A triangle that emits light, or may, where a texture decides.
struct RayEmitter {
  uint corners[3];  // vertices of the mesh
  uint instance;    // index in FrameConstants::instances
};
SH_CONST uint kRayEmitterBytes = 16u;

// A grid over the directions of an environment in its own frame, by which rays choose bright directions. Columns have
// equal ranges of longitude and rows equal ranges of latitude, as in the equirectangular image. Its table has the
// cumulative distribution of the rows, uint[kEnvironmentRows], and of the cells in each row,
// uint[kEnvironmentRows][kEnvironmentColumns]: the fraction of choices that come before an element, times 2^32. Unlike
// an alias table, its inverse is monotonic, so points that are well distributed in the square remain so among the
// cells.
SH_CONST uint kEnvironmentColumns = 1024u;  // powers of two
SH_CONST uint kEnvironmentRows = 512u;
SH_CONST uint kEnvironmentTableBytes = 4u * kEnvironmentRows * (kEnvironmentColumns + 1u);

// The values match those of Indirect; 0 is none.
SH_CONST uint kIndirectOneBounce = 1u;
SH_CONST uint kIndirectPath = 2u;

// Shadows by rays instead of maps: one light in one view, in FrameConstants::shadowMaps[viewCount][shadowColumns], or
// in all views of a world or of a scene, in FrameConstants::shadowMaps[shadowColumns].
struct RayShadow {  // 16 bytes
  uint light;       // index in FrameConstants::lights; kRayNone: the world has fewer lights
  uint rays;        // per surface; 0: the light casts no shadows in this view
  float lightSize;  // radius of the light in meters; for a directional light, the tangent of its angular radius
  uint padding;
};
SH_CONST uint kShadowRays = 5u;  // the value of ShadowFormat

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::RayNode) == latelight::shared::kRayNodeBytes);
static_assert(sizeof(latelight::shared::RayInstance) == latelight::shared::kRayInstanceBytes);
static_assert(sizeof(latelight::shared::RayTriangle) == 16);
static_assert(sizeof(latelight::shared::RayEmitter) == latelight::shared::kRayEmitterBytes);
static_assert(sizeof(latelight::shared::RayScene) == latelight::shared::kRaySceneBytes);
#endif

#endif
