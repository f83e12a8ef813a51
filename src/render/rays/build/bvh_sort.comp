#version 460
#extension GL_GOOGLE_include_directive : require
// Moves keys and items to the positions that a pass of the radix sort assigns to them (sort_keys.glsl). The counters
// are the positions of the first key of each digit and workgroup.
#include "render/rays/build/sort_keys.glsl"

layout(local_size_x = kBuildGroup) in;

shared uint before[kDigits / 2u * kBuildGroup];  // counts of two digits in earlier invocations, by pair of digits
shared uint subgroupPairs[kDigits / 2u * kBuildGroup / kMinLanes];

void countEarlierKeys(uint64_t counts) {
  for (uint i = 0u; i < kDigits / 2u; ++i) {
    uint pair = pairOf(counts, i);
    before[i * kBuildGroup + invocation()] = subgroupExclusiveAdd(pair);
    uint sum = subgroupAdd(pair);
    if (subgroupElect()) subgroupPairs[i * gl_NumSubgroups + gl_SubgroupID] = sum;
  }
  barrier();
  for (uint i = 0u; i < kDigits / 2u; ++i) {
    uint earlier = 0u;
    for (uint j = 0u; j < gl_SubgroupID; ++j) earlier += subgroupPairs[i * gl_NumSubgroups + j];
    before[i * kBuildGroup + invocation()] += earlier;
  }
}

void main() {
  BvhBuild build = BvhBuildRef(push.build).v;
  uint groups = groupsFor(build.count, kKeysPerGroup);
  if (workgroup() >= groups) return;
  KeysRef from = KeysRef(build.keys[push.step & 1u]), to = KeysRef(build.keys[~push.step & 1u]);
  BuildWordsRef items = BuildWordsRef(build.items[push.step & 1u]);
  BuildWordsRef sorted = BuildWordsRef(build.items[~push.step & 1u]);
  uint first = firstKey(), end = min(first + kKeysPerInvocation, build.count);
  uint64_t counts = 0ul;
  for (uint i = first; i < end; ++i) counts += 1ul << kDigitBits * digitOf(from.v[i]);
  countEarlierKeys(counts);
  counts = 0ul;
  for (uint i = first; i < end; ++i) {
    uint64_t key = from.v[i];
    uint digit = digitOf(key);
    uint at = BuildWordsRef(build.counters).v[digit * groups + workgroup()] +
              (before[digit / 2u * kBuildGroup + invocation()] >> 16u * (digit & 1u) & 0xffffu) +
              (uint(counts >> kDigitBits * digit) & 15u);
    counts += 1ul << kDigitBits * digit;
    to.v[at] = key;
    sorted.v[at] = items.v[i];
  }
}
