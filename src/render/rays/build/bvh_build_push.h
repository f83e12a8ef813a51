// The data of a BVH build on the device (device_bvh_builder.h), and the push constants of its shaders.
#ifndef LATELIGHT_RENDER_RAYS_BUILD_BVH_BUILD_PUSH_H
#define LATELIGHT_RENDER_RAYS_BUILD_BVH_BUILD_PUSH_H

#include "shared/rays.h"

SH_BEGIN

SH_CONST uint kBuildGroup = 256u;  // invocations per workgroup
SH_CONST uint kBuildRow = 32768u;  // workgroups per row of a dispatch, because their count per axis is limited

SH_CONST uint kCodeAxisBits = 16u;      // of a Morton code, per axis
SH_CONST uint kDigitBits = 4u;          // of a key, per pass of the radix sort
SH_CONST uint kDigits = 16u;            // 1 << kDigitBits
SH_CONST uint kKeysPerInvocation = 8u;  // in the radix sort: at most 15, so that their number fits a digit
SH_CONST uint kKeysPerGroup = 2048u;    // kBuildGroup * kKeysPerInvocation

// A cluster looks for its neighbor among kNeighbors clusters on either side. A workgroup finds those of kBuildGroup
// clusters, and merges the kMergedPerGroup in their middle.
SH_CONST uint kNeighbors = 8u;
SH_CONST uint kMergedPerGroup = 240u;  // kBuildGroup - 2 * kNeighbors

SH_CONST uint kMaxMeshesPerBuild = 65536u;
SH_CONST uint kMaxRounds = 80u;  // of merging

// One of the meshes that a build processes together.
struct BuildMesh {
  uint64_t positions;  // VertexPosition[]
  uint64_t indices;    // uint[3] per triangle
  vec3 low;            // the center of a triangle's box, minus this and times `scale`, is a cell of the grid
  float scale;         //   of Morton codes
  uint64_t nodes;      // RayNode[] and
  uint64_t triangles;  //   RayTriangle[], written
  uint first;          // index of its first triangle among those of all meshes
  uint root;           // as BuildCluster::reference
  uint paddingA, paddingB;
};

// A root of a subtree that has no parent yet.
struct BuildCluster {  // 32 bytes
  vec3 low;
  uint reference;  // kRayLeaf and a position in the order of keys, or the index of a BuildNode
  vec3 high;
  uint mesh;  // index of the BuildMesh, shifted by kHeightBits; the number of nodes on the longest path to a leaf
};
SH_CONST uint kBuildClusterBytes = 32u;
SH_CONST uint kHeightBits = 6u;
SH_CONST uint kHeightMask = 63u;

// As RayNode, before it is known where nodes are stored.
struct BuildNode {
  vec3 lowA;
  uint a;  // as BuildCluster::reference
  vec3 highA;
  uint b;
  vec3 lowB;
  uint items;  // number of triangles below, and kBecomesLeaf
  vec3 highB;
  uint nodes;  // inner nodes of the subtree, including this one; 0 if it becomes a leaf
};
SH_CONST uint kBecomesLeaf = 0x80000000u;

// Where a BuildNode is stored.
struct BuildPlace {
  uint index;   // in the mesh's nodes
  uint first;   // index of its first triangle, in the order of leaves
  uint parent;  // as RayNode::parent
  uint mesh;    // index of the BuildMesh; kRayNone: the node is part of a leaf
};

// A cluster that remains after the rounds, for the host. It is a child of the nodes that the host builds, or a root.
struct BuildResult {
  BuildCluster cluster;  // mesh: kRayNone if fewer clusters remain
  uint items, nodes;     // as BuildNode
};

struct BuildState {
  uint clusters[kMaxRounds + 1u];       // before each round, and after the last one
  uint finished;                        // number of rounds until BvhBuild::target is reached
  uvec3 mergeGroups[kMaxRounds + 1u];   // workgroups that merge in each round
  uint placed[kHeightMask + 1u];        // nodes of each level, which BvhBuild::queues lists
  uvec3 placeGroups[kHeightMask + 1u];  // workgroups that place the children of each level
};

struct BvhBuild {
  uint64_t meshes;   // BuildMesh[meshCount]
  uint64_t results;  // BuildResult[target], written
  uint64_t state;    // BuildState
  uint64_t keys[2];  // uint64_t[count]: passes of the sort read one and write the other; and so on for the arrays below
  uint64_t items[2];  // uint[count]: triangles in the order of keys
  uint64_t counters;  // uint[]: of the sort, by digit and workgroup; of a round, see bvh_neighbors.comp
  // BuildCluster[]: before even and odd rounds. The first one ends where `nodes` end, so its clusters move toward the
  // end as they become fewer. A round merges at most half of them, and has written a node for each missing cluster.
  uint64_t clusters[2];
  uint64_t partners;   // uint[count]
  uint64_t nodes;      // BuildNode[count]
  uint64_t places;     // BuildPlace[count]
  uint64_t queues[2];  // uint[count]: indices of nodes of even and odd levels
  uint count;          // triangles of all meshes
  uint meshCount;
  uint target;    // rounds end when at most so many clusters remain
  uint rounds;    // maximum number of rounds
  uint maxDepth;  // inner nodes on any path
};

struct BvhBuildPush {
  uint64_t build;  // BvhBuild
  uint step;       // pass of the sort, or round
  uint values;     // bvh_scan.comp: number of values; 0: those of the round
};

// Returns half of the area of a box, finite also for boxes as large as floats can express.
SH_FUNC float boxArea(vec3 low, vec3 high) {
  vec3 extent = min(high - low, vec3(1e18f, 1e18f, 1e18f));
  return extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
}

// Returns true if a node is to become a leaf, because that reduces the cost by the surface area heuristic. `children`:
// the sum of their areas times their numbers of triangles.
SH_FUNC bool becomesLeaf(uint items, float area, float children) {
  return items <= kMaxRayLeaf && area * kRayNodeCost + children >= float(items) * area;
}

// Returns the smallest k with 2^k >= x, for x >= 1.
SH_FUNC uint ceilLog2(uint x) {
  uint k = 0u;
  while (k < 31u && (1u << k) < x) ++k;
  return k;
}

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::BuildCluster) == latelight::shared::kBuildClusterBytes);
static_assert(sizeof(latelight::shared::BuildNode) == sizeof(latelight::shared::RayNode));
#endif

#endif
