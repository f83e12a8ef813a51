// Spherical coordinates with both angles: about Z, and from +Z. It costs one more atan2, sine and cosine than angle and
// z. It is nowhere inaccurate; instead, its codes are denser at the poles.
#ifndef LATELIGHT_SHARED_NORMAL_SPHERICAL_ANGLES_H
#define LATELIGHT_SHARED_NORMAL_SPHERICAL_ANGLES_H

#include "shared/normal/spherical_z.h"

#define NORMAL_DESCRIPTION_spherical_angles "spherical coordinates: the angle about Z, and the angle from +Z"

SH_BEGIN

SH_CONST uint kNormalChannels_spherical_angles = 2u;
SH_CONST uint kNormalHemisphere_spherical_angles = 0u;

// atan2 also for the polar angle, because acos loses half its digits at the poles.
SH_FUNC vec3 encodeNormal_spherical_angles(vec3 n, SH_UNUSED vec3 levels) {
  float polar = atan2(sqrt(n.x * n.x + n.y * n.y), n.z) * kInvPi;
  return vec3(azimuthOf(n) * 0.5f + 0.5f, polar, 0.0f);
}

SH_FUNC vec3 decodeNormal_spherical_angles(vec3 e, SH_UNUSED vec3 levels) {
  float angle = (e.x * 2.0f - 1.0f) * kPi;
  float polar = e.y * kPi;
  float r = sin(polar);
  return vec3(cos(angle) * r, sin(angle) * r, cos(polar));
}

SH_END

#endif
