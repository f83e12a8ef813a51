// Lambert azimuthal equal-area projection (Lambert 1772; Snyder 1987, "Map Projections: A Working Manual", chapter 24;
// for normals Pranckevicius 2009, "Compact Normal Storage for small G-Buffers"). It maps to the same disc as the
// spheremap by another formula, without normalization and without a singularity at +Z.
//
//   encode  n.xy / sqrt(8 n.z + 8) + 0.5
#ifndef LATELIGHT_SHARED_NORMAL_LAMBERT_H
#define LATELIGHT_SHARED_NORMAL_LAMBERT_H

#include "shared/lang.h"

#define NORMAL_DESCRIPTION_lambert "Lambert azimuthal equal-area projection; least accurate for normals that face away"

SH_BEGIN

SH_CONST uint kNormalChannels_lambert = 2u;
SH_CONST uint kNormalHemisphere_lambert = 0u;

// 8 z + 8 loses precision near -Z; 8 |n.xy|^2 / (1 - z) is the same number without that loss. The whole rim represents
// -Z.
SH_FUNC vec3 encodeNormal_lambert(vec3 n, SH_UNUSED vec3 levels) {
  float squared = n.x * n.x + n.y * n.y;
  if (n.z < 0.0f && squared < 1e-30f) return vec3(1.0f, 0.5f, 0.0f);
  float s = inversesqrt(n.z >= 0.0f ? 8.0f * n.z + 8.0f : 8.0f * squared / (1.0f - n.z));
  return vec3(n.x * s + 0.5f, n.y * s + 0.5f, 0.0f);
}

// Points that rounding moved outside the disc decode to -Z.
SH_FUNC vec3 decodeNormal_lambert(vec3 e, SH_UNUSED vec3 levels) {
  float x = e.x * 4.0f - 2.0f;
  float y = e.y * 4.0f - 2.0f;
  float f = min(x * x + y * y, 4.0f);
  float g = sqrt(1.0f - f * 0.25f);
  return vec3(x * g, y * g, 1.0f - f * 0.5f);
}

SH_END

#endif
