#version 460
#extension GL_GOOGLE_include_directive : require
// Replaces each of the counters by the sum of those before it, in one workgroup. After a round of merging, it also
// writes the size of the next one, which is empty once build.target is reached.
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

void scan(BuildWordsRef values, uint count) {
  uint share = groupsFor(count, kBuildGroup), first = min(invocation() * share, count), end = min(first + share, count);
  uint sum = 0u, total;
  for (uint i = first; i < end; ++i) sum += values.v[i];
  uint before = exclusiveScan(sum, total);
  for (uint i = first; i < end; ++i) {
    uint value = values.v[i];
    values.v[i] = before;
    before += value;
  }
}

void main() {
  BvhBuild build = BvhBuildRef(push.build).v;
  BuildWordsRef counters = BuildWordsRef(build.counters);
  if (push.values != 0u) {
    scan(counters, push.values);
    return;
  }
  BuildStateRef state = BuildStateRef(build.state);
  uint clusters = state.v.clusters[push.step], remaining = clusters;
  bool complete = clusters <= build.target;
  if (!complete) {
    uint groups = groupsFor(clusters, kMergedPerGroup);
    scan(counters, 2u * groups);
    memoryBarrierBuffer();
    barrier();
    remaining = counters.v[groups];
  }
  if (invocation() > 0u) return;
  state.v.clusters[push.step + 1u] = remaining;
  state.v.mergeGroups[push.step + 1u] =
      groupsOf(remaining <= build.target ? 0u : groupsFor(remaining, kMergedPerGroup));
  if (!complete) state.v.finished = push.step + 1u;
}
