#version 460
#extension GL_GOOGLE_include_directive : require
// Counts the keys of each workgroup by digit (sort_keys.glsl): build.counters, all workgroups of digit 0 first.
#include "render/rays/build/sort_keys.glsl"

layout(local_size_x = kBuildGroup) in;

shared uint sums[kDigits / 2u];

void main() {
  BvhBuild build = BvhBuildRef(push.build).v;
  uint groups = groupsFor(build.count, kKeysPerGroup);
  if (workgroup() >= groups) return;
  if (invocation() < kDigits / 2u) sums[invocation()] = 0u;
  barrier();
  KeysRef keys = KeysRef(build.keys[push.step & 1u]);
  uint first = firstKey();
  uint64_t counts = 0ul;
  for (uint i = first; i < min(first + kKeysPerInvocation, build.count); ++i)
    counts += 1ul << kDigitBits * digitOf(keys.v[i]);
  for (uint i = 0u; i < kDigits / 2u; ++i) {
    uint sum = subgroupAdd(pairOf(counts, i));
    if (subgroupElect()) atomicAdd(sums[i], sum);
  }
  barrier();
  uint digit = invocation();
  if (digit >= kDigits) return;
  BuildWordsRef(build.counters).v[digit * groups + workgroup()] = sums[digit / 2u] >> 16u * (digit & 1u) & 0xffffu;
}
