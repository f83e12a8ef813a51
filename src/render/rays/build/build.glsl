// Buffers and functions that the shaders of a BVH build share (device_bvh_builder.h).
#ifndef LATELIGHT_RAYS_BUILD_GLSL
#define LATELIGHT_RAYS_BUILD_GLSL
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "render/glsl/common.glsl"
#include "render/rays/build/bvh_build_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BvhBuildRef { BvhBuild v; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BuildMeshesRef { BuildMesh v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer KeysRef { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer BuildWordsRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer BuildClustersRef { BuildCluster v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer BuildNodesRef { BuildNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer BuildPlacesRef { BuildPlace v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer BuildResultsRef { BuildResult v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer BuildStateRef { BuildState v; };

layout(push_constant, scalar) uniform Push { BvhBuildPush push; };

uint workgroup() { return gl_WorkGroupID.y * kBuildRow + gl_WorkGroupID.x; }
// The index of this invocation in its workgroup. Scans over subgroups, in the order of their numbers, have this order.
uint invocation() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }
uvec3 groupsOf(uint groups) { return uvec3(min(groups, kBuildRow), (groups + kBuildRow - 1u) / kBuildRow, 1u); }
uint groupsFor(uint count, uint perGroup) { return (count + perGroup - 1u) / perGroup; }

struct BuildBox {
  vec3 low, high;
};

BuildBox triangleBox(BuildMesh mesh, uint triangle) {
  UintRef indices = UintRef(mesh.indices);
  vec3 a = positionAt(mesh.positions, indices.v[3u * triangle]);
  vec3 b = positionAt(mesh.positions, indices.v[3u * triangle + 1u]);
  vec3 c = positionAt(mesh.positions, indices.v[3u * triangle + 2u]);
  return BuildBox(min(a, min(b, c)), max(a, max(b, c)));
}

// The address of the clusters before a round, of which there are `count`: BvhBuild::clusters.
uint64_t clustersOf(BvhBuild build, uint round, uint count) {
  uint64_t others = uint64_t(build.count - count);
  return build.clusters[round & 1u] + ((round & 1u) == 0u ? others * kBuildClusterBytes : 0ul);
}

bool isItem(uint reference) { return (reference & kRayLeaf) != 0u; }

// --- scans -----------------------------------------------------------------------------------------------------------

const uint kMinLanes = 4u;
shared uint subgroupSums[kBuildGroup / kMinLanes];

// Returns the sum over the invocations of the workgroup before this one, and the total. All invocations must call it.
uint exclusiveScan(uint value, out uint total) {
  uint before = subgroupExclusiveAdd(value), sum = subgroupAdd(value);
  barrier();  // the sums may still be read, by an earlier call
  if (subgroupElect()) subgroupSums[gl_SubgroupID] = sum;
  barrier();
  total = 0u;
  for (uint i = 0u; i < gl_NumSubgroups; ++i) {
    if (i < gl_SubgroupID) before += subgroupSums[i];
    total += subgroupSums[i];
  }
  return before;
}

#endif
