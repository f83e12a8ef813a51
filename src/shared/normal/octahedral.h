// Octahedral encoding: the sphere folded onto a square (Meyer et al. 2010, On Floating-Point Normal Vectors; Cigolle et
// al. 2014, A Survey of Efficient Representations for Independent Unit Vectors, JCGT 3(2)).
#ifndef LATELIGHT_SHARED_NORMAL_OCTAHEDRAL_H
#define LATELIGHT_SHARED_NORMAL_OCTAHEDRAL_H

#include "shared/unorm.h"

#define NORMAL_DESCRIPTION_octahedral "octahedral map of the sphere to a square: uniform accuracy; the default"

SH_BEGIN

// Unit direction to octahedral coordinates in [-1, 1]^2; +Z is the center. The lower half wraps by (1 - |v.yx|) *
// sign(v.xy), where sign(0) is 1. (Copies of this code often lack parentheses around the conditional sign.)
SH_FUNC vec2 octahedralFromDirection(vec3 d) {
  float s = 1.0f / (abs(d.x) + abs(d.y) + abs(d.z));
  float x = d.x * s;
  float y = d.y * s;
  if (d.z < 0.0f) {
    float wrapped = (1.0f - abs(y)) * (x >= 0.0f ? 1.0f : -1.0f);
    y = (1.0f - abs(x)) * (y >= 0.0f ? 1.0f : -1.0f);
    x = wrapped;
  }
  return vec2(x, y);
}

// The inverse of octahedralFromDirection.
SH_FUNC vec3 directionFromOctahedral(vec2 o) {
  float z = 1.0f - abs(o.x) - abs(o.y);
  float t = saturate(-z);
  return normalize(vec3(o.x + (o.x >= 0.0f ? -t : t), o.y + (o.y >= 0.0f ? -t : t), z));
}

SH_CONST uint kNormalChannels_octahedral = 2u;
SH_CONST uint kNormalHemisphere_octahedral = 0u;

SH_FUNC vec3 encodeNormal_octahedral(vec3 n, vec3 levels) {
  vec2 o = octahedralFromDirection(n);
  return vec3(unormFromSigned(o.x, levels.x), unormFromSigned(o.y, levels.y), 0.0f);
}

SH_FUNC vec3 decodeNormal_octahedral(vec3 e, vec3 levels) {
  return directionFromOctahedral(vec2(signedFromUnorm(e.x, levels.x), signedFromUnorm(e.y, levels.y)));
}

SH_END

#endif
