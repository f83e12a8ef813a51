#version 460
#extension GL_GOOGLE_include_directive : require
// Replaces each of the counters by the sum of those before it, in one workgroup. After a round of merging, it also
// writes the size of the next one, which is empty once build.target is reached.
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

// Consecutive values of an invocation, so that few barriers are needed and many loads are in flight.
const uint kValuesPerInvocation = 16u;

void scan(BuildWordsRef values, uint count) {
  uint carried = 0u, total;
  for (uint start = 0u; start < count; start += kBuildGroup * kValuesPerInvocation) {
    uint first = start + invocation() * kValuesPerInvocation, sum = 0u;
    uint sums[kValuesPerInvocation];  // of the values before each one
    for (uint i = 0u; i < kValuesPerInvocation; ++i) {
      uint value = first + i < count ? values.v[first + i] : 0u;
      sums[i] = sum;
      sum += value;
    }
    uint before = carried + exclusiveScan(sum, total);
    for (uint i = 0u; i < kValuesPerInvocation; ++i)
      if (first + i < count) values.v[first + i] = before + sums[i];
    carried += total;
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
