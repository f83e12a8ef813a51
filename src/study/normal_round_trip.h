// The round trip of a normal through its stored bits, in GLSL and C++.
#ifndef LATELIGHT_STUDY_NORMAL_ROUND_TRIP_H
#define LATELIGHT_STUDY_NORMAL_ROUND_TRIP_H

#include "normals.h"
#include "shared/unorm.h"

SH_BEGIN

// `bits` per channel, 8 to 16, are stored as integers in two words; 0 means float channels.
SH_FUNC vec3 normalRoundTrip(uint encoding, uint bits, vec3 n) {
  float levels = float((1u << bits) - 1u);
  vec3 all = vec3(levels, levels, levels);
  vec3 e = encodeNormal(encoding, n, all);
  if (bits == 0u) return decodeNormal(encoding, e, all);
  uint xy = unormCode(e.x, levels) | (unormCode(e.y, levels) << 16u);
  uint z = unormCode(e.z, levels);
  vec3 stored = vec3(unormValue(xy & 0xffffu, levels), unormValue(xy >> 16u, levels), unormValue(z, levels));
  return decodeNormal(encoding, stored, all);
}

SH_END

#endif
