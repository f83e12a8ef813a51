// The keys of a workgroup in a pass of the radix sort: least significant digits first, and stable, so that the result
// does not depend on the order in which workgroups run. Each invocation has a few consecutive keys. Their number per
// digit fits 4 bits, and that of a workgroup 16.
#ifndef LATELIGHT_RAYS_SORT_KEYS_GLSL
#define LATELIGHT_RAYS_SORT_KEYS_GLSL
#include "render/rays/build/build.glsl"

uint digitOf(uint64_t key) { return uint(key >> kDigitBits * push.step) & (kDigits - 1u); }

uint firstKey() { return workgroup() * kKeysPerGroup + invocation() * kKeysPerInvocation; }

// The counts of two digits, 2 * i and 2 * i + 1, of those of 16 digits in 4 bits each.
uint pairOf(uint64_t counts, uint i) {
  uint pair = uint(counts >> 2u * kDigitBits * i);
  return (pair & 15u) | (pair & 240u) << 12;
}

#endif
