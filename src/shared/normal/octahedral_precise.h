// Precise octahedral encoding: the one of the four codes around a direction that decodes nearest to it (Cigolle et al.
// 2014, JCGT 3(2), "oct-precise"). Rounding each coordinate separately does not find this code, because the map shears.
// It decodes like octahedral; only encoding costs more.
#ifndef LATELIGHT_SHARED_NORMAL_OCTAHEDRAL_PRECISE_H
#define LATELIGHT_SHARED_NORMAL_OCTAHEDRAL_PRECISE_H

#include "shared/normal/octahedral.h"

#define NORMAL_DESCRIPTION_octahedral_precise "octahedral, with the nearest of the four neighboring codes"

SH_BEGIN

SH_CONST uint kNormalChannels_octahedral_precise = 2u;
SH_CONST uint kNormalHemisphere_octahedral_precise = 0u;

// Compares distances instead of cosines, which are all 1 in 32 bits for nearby directions.
SH_FUNC vec3 encodeNormal_octahedral_precise(vec3 n, vec3 levels) {
  if (levels.x <= 0.0f || levels.y <= 0.0f) return encodeNormal_octahedral(n, levels);
  vec2 o = octahedralFromDirection(n);
  float zeroX = (levels.x - 1.0f) * 0.5f;
  float zeroY = (levels.y - 1.0f) * 0.5f;
  vec2 best = o;
  float nearest = 8.0f;
  for (uint i = 0u; i < 4u; i += 1u) {
    float x = min(floor(o.x * zeroX) + float(i & 1u), zeroX) / zeroX;
    float y = min(floor(o.y * zeroY) + float(i >> 1u), zeroY) / zeroY;
    vec3 away = directionFromOctahedral(vec2(x, y)) - n;
    float squared = dot(away, away);
    if (squared < nearest) {
      nearest = squared;
      best = vec2(x, y);
    }
  }
  return vec3(unormFromSigned(best.x, levels.x), unormFromSigned(best.y, levels.y), 0.0f);
}

SH_FUNC vec3 decodeNormal_octahedral_precise(vec3 e, vec3 levels) {
  return decodeNormal_octahedral(e, levels);
}

SH_END

#endif
