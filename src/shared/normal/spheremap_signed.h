// Spheremap in the signed form of seed 000's optimised G-buffer, which stores the point of the disc unchanged, for
// SNORM and float targets. (The slide writes n.xy * sqrt(-n.z * 0.5 + 0.5): it omits normalising n.xy, and its own
// decoder then returns another direction.) In UNORM channels it is stored as SNORM would, with a code for 0.
#ifndef LATELIGHT_SHARED_NORMAL_SPHEREMAP_SIGNED_H
#define LATELIGHT_SHARED_NORMAL_SPHEREMAP_SIGNED_H

#include "shared/normal/spheremap.h"
#include "shared/unorm.h"

#define NORMAL_DESCRIPTION_spheremap_signed "CryEngine 3's spheremap in [-1, 1], 0 a code of its own"

SH_BEGIN

SH_CONST uint kNormalChannels_spheremap_signed = 2u;
SH_CONST uint kNormalHemisphere_spheremap_signed = 0u;

SH_FUNC vec3 encodeNormal_spheremap_signed(vec3 n, vec3 levels) {
  vec2 p = spheremapFromDirection(n);
  return vec3(unormFromSigned(p.x, levels.x), unormFromSigned(p.y, levels.y), 0.0f);
}

SH_FUNC vec3 decodeNormal_spheremap_signed(vec3 e, vec3 levels) {
  return directionFromSpheremap(vec2(signedFromUnorm(e.x, levels.x), signedFromUnorm(e.y, levels.y)));
}

SH_END

#endif
