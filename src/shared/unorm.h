// Stores numbers in [-1, 1] in UNORM channels, with a code for 0. A channel of b bits has 2^b codes, an even number, so
// x * 0.5 + 0.5 puts 0 between two codes. Without the last code, 0 has its own code, as in SNORM formats. An
// axis-aligned normal is then decoded exactly.
//
// `levels` is 2^b - 1, or 0 for a float channel, which needs no such correction.
#ifndef LATELIGHT_SHARED_UNORM_H
#define LATELIGHT_SHARED_UNORM_H

#include "shared/lang.h"

SH_BEGIN

SH_FUNC float unormFromSigned(float x, float levels) {
  float share = levels > 0.0f ? (levels - 1.0f) / levels : 1.0f;
  return (x * 0.5f + 0.5f) * share;
}

// Rounds to the code first: a device's UNORM conversion may be off in the last bit, and 0 must be decoded as 0.
SH_FUNC float signedFromUnorm(float u, float levels) {
  if (levels <= 0.0f) return u * 2.0f - 1.0f;
  float zero = (levels - 1.0f) * 0.5f;
  return min((floor(u * levels + 0.5f) - zero) / zero, 1.0f);
}

// The code that a UNORM channel of up to 24 bits stores for a number, and the number decoded from it. (Adding 0.5
// before floor() would round by itself when codes need all 24 bits of a float.)
SH_FUNC uint unormCode(float x, float levels) {
  float scaled = saturate(x) * levels;
  float whole = floor(scaled);
  return uint(whole) + (scaled - whole >= 0.5f ? 1u : 0u);
}
SH_FUNC float unormValue(uint code, float levels) {
  return float(code) / levels;
}

SH_END

#endif
