// Spheremap of CryEngine 3 (Mittring 2009, "A bit more deferred"), in [0, 1]. It maps the sphere to a disc, with +Z at
// its center and -Z as its whole rim. It is designed for view space, where few normals are near the rim.
//
//   encode  normalize(n.xy) * sqrt(0.5 - 0.5 n.z)
//
// normalize() is undefined at the poles, and near +Z the root of 1 - z loses precision. Since |n.xy|^2 = (1 - z)(1 +
// z), the same point is n.xy / sqrt(2 + 2 z), which the near half uses. The far half, where 1 + z loses precision, uses
// the original formula.
#ifndef LATELIGHT_SHARED_NORMAL_SPHEREMAP_H
#define LATELIGHT_SHARED_NORMAL_SPHEREMAP_H

#include "shared/lang.h"

#define NORMAL_DESCRIPTION_spheremap "CryEngine 3's spheremap in [0, 1]; least accurate for normals that face away"

SH_BEGIN

// Unit direction to a point of the unit disc.
SH_FUNC vec2 spheremapFromDirection(vec3 n) {
  float squared = n.x * n.x + n.y * n.y;
  float s = n.z >= 0.0f ? inversesqrt(2.0f + 2.0f * n.z) : sqrt(0.5f - 0.5f * n.z) * inversesqrt(max(squared, 1e-30f));
  if (n.z < 0.0f && squared < 1e-30f) return vec2(1.0f, 0.0f);  // -Z maps to any point of the rim
  return vec2(n.x * s, n.y * s);
}

// The inverse of spheremapFromDirection. Points that rounding moved outside the disc decode to -Z.
SH_FUNC vec3 directionFromSpheremap(vec2 p) {
  float f = max(1.0f - p.x * p.x - p.y * p.y, 0.0f);
  float s = 2.0f * sqrt(f);
  return vec3(p.x * s, p.y * s, 2.0f * f - 1.0f);
}

SH_CONST uint kNormalChannels_spheremap = 2u;
SH_CONST uint kNormalHemisphere_spheremap = 0u;

SH_FUNC vec3 encodeNormal_spheremap(vec3 n, SH_UNUSED vec3 levels) {
  vec2 p = spheremapFromDirection(n);
  return vec3(p.x * 0.5f + 0.5f, p.y * 0.5f + 0.5f, 0.0f);
}

SH_FUNC vec3 decodeNormal_spheremap(vec3 e, SH_UNUSED vec3 levels) {
  return directionFromSpheremap(vec2(e.x * 2.0f - 1.0f, e.y * 2.0f - 1.0f));
}

SH_END

#endif
