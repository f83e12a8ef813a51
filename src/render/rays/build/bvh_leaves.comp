#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the clusters before the first round of merging: one per triangle, in the order of keys.
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

void main() {
  uint index = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  if (index >= build.count) return;
  uint meshIndex = uint(KeysRef(build.keys[0]).v[index] >> 3u * kCodeAxisBits);
  BuildMesh mesh = BuildMeshesRef(build.meshes).v[meshIndex];
  BuildBox box = triangleBox(mesh, BuildWordsRef(build.items[0]).v[index] - mesh.first);
  BuildClustersRef(build.clusters[0]).v[index] =
      BuildCluster(box.low, kRayLeaf | index, box.high, meshIndex << kHeightBits);
  if (index > 0u) return;
  BuildStateRef state = BuildStateRef(build.state);
  state.v.clusters[0] = build.count;
  state.v.mergeGroups[0] = groupsOf(build.count <= build.target ? 0u : groupsFor(build.count, kMergedPerGroup));
  state.v.finished = 0u;
  for (uint level = 0u; level <= kHeightMask; ++level) {
    state.v.placed[level] = 0u;
    state.v.placeGroups[level] = uvec3(0u, 0u, 1u);
  }
}
