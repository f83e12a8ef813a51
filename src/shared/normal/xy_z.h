// XY with reconstructed Z, as in Killzone 2 (Valient 2007, "Deferred Rendering in Killzone 2"). It does not store the
// sign of z, so a normal that points away is decoded as its mirror image on the near side. It is restricted to view
// space, with +Z toward the viewer. With normal maps and perspective, some visible normals still point away.
#ifndef LATELIGHT_SHARED_NORMAL_XY_Z_H
#define LATELIGHT_SHARED_NORMAL_XY_Z_H

#include "shared/lang.h"

#define NORMAL_DESCRIPTION_xy_z "x and y; z is reconstructed as the positive root (Killzone 2)"

SH_BEGIN

SH_CONST uint kNormalChannels_xy_z = 2u;
SH_CONST uint kNormalHemisphere_xy_z = 1u;

SH_FUNC vec3 encodeNormal_xy_z(vec3 n, SH_UNUSED vec3 levels) {
  return vec3(n.x * 0.5f + 0.5f, n.y * 0.5f + 0.5f, 0.0f);
}

// Rounding may make the length of (x, y) exceed 1 at the rim. Then z is 0, and (x, y) is normalized.
SH_FUNC vec3 decodeNormal_xy_z(vec3 e, SH_UNUSED vec3 levels) {
  float x = e.x * 2.0f - 1.0f;
  float y = e.y * 2.0f - 1.0f;
  return normalize(vec3(x, y, sqrt(max(1.0f - x * x - y * y, 0.0f))));
}

SH_END

#endif
