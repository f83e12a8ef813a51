// XYZ: the three components, each remapped from [-1, 1] to [0, 1].
#ifndef LATELIGHT_SHARED_NORMAL_XYZ_H
#define LATELIGHT_SHARED_NORMAL_XYZ_H

#include "shared/lang.h"

#define NORMAL_DESCRIPTION_xyz "all three components, n * 0.5 + 0.5"

SH_BEGIN

SH_CONST uint kNormalChannels_xyz = 3u;
SH_CONST uint kNormalHemisphere_xyz = 0u;

SH_FUNC vec3 encodeNormal_xyz(vec3 n, SH_UNUSED vec3 levels) {
  return vec3(n.x * 0.5f + 0.5f, n.y * 0.5f + 0.5f, n.z * 0.5f + 0.5f);
}

SH_FUNC vec3 decodeNormal_xyz(vec3 e, SH_UNUSED vec3 levels) {
  return normalize(vec3(e.x * 2.0f - 1.0f, e.y * 2.0f - 1.0f, e.z * 2.0f - 1.0f));
}

SH_END

#endif
