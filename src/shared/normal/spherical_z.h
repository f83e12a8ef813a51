// Spherical coordinates (Pranckevicius 2009, "Compact Normal Storage for Small G-Buffers"): the angle about Z, and z.
// The cylindrical projection preserves areas, so the mean error is nearly optimal. Near a pole z barely depends on the
// angle from it, and the error is largest.
#ifndef LATELIGHT_SHARED_NORMAL_SPHERICAL_Z_H
#define LATELIGHT_SHARED_NORMAL_SPHERICAL_Z_H

#include "shared/lang.h"

#define NORMAL_DESCRIPTION_spherical_z "spherical coordinates: the angle about Z, and z"

SH_BEGIN

// Angle about Z in half turns, [-1, 1]; 0 at the poles, where atan2 is undefined.
SH_FUNC float azimuthOf(vec3 n) {
  if (n.x == 0.0f && n.y == 0.0f) return 0.0f;
  return atan2(n.y, n.x) * kInvPi;
}

SH_CONST uint kNormalChannels_spherical_z = 2u;
SH_CONST uint kNormalHemisphere_spherical_z = 0u;

SH_FUNC vec3 encodeNormal_spherical_z(vec3 n, SH_UNUSED vec3 levels) {
  return vec3(azimuthOf(n) * 0.5f + 0.5f, n.z * 0.5f + 0.5f, 0.0f);
}

SH_FUNC vec3 decodeNormal_spherical_z(vec3 e, SH_UNUSED vec3 levels) {
  float angle = (e.x * 2.0f - 1.0f) * kPi;
  float z = e.y * 2.0f - 1.0f;
  float r = sqrt(max(1.0f - z * z, 0.0f));
  return vec3(cos(angle) * r, sin(angle) * r, z);
}

SH_END

#endif
