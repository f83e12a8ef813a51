// Signed spheremap: the point of the unit disc in [-1, 1], for SNORM and float targets. n.xy must be normalized; n.xy *
// sqrt(-n.z * 0.5 + 0.5), which some courses show, does not match the decoder. UNORM channels store it like SNORM
// channels, with a code for 0.
#ifndef LATELIGHT_SHARED_NORMAL_SPHEREMAP_SIGNED_H
#define LATELIGHT_SHARED_NORMAL_SPHEREMAP_SIGNED_H

#include "shared/normal/spheremap.h"
#include "shared/unorm.h"

#define NORMAL_DESCRIPTION_spheremap_signed "CryEngine 3's spheremap in [-1, 1], with a code for 0"

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
