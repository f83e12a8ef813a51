// Hemi-octahedral normal encoding: the half of the octahedron for the near hemisphere, rotated by 45 degrees so that it
// fills the square (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", JCGT
// 3(2)).
#ifndef LATELIGHT_SHARED_NORMAL_HEMI_OCTAHEDRAL_H
#define LATELIGHT_SHARED_NORMAL_HEMI_OCTAHEDRAL_H

#include "shared/unorm.h"

#define NORMAL_DESCRIPTION_hemi_octahedral "the near hemisphere on the whole square: half the octahedral error"

SH_BEGIN

SH_CONST uint kNormalChannels_hemi_octahedral = 2u;
SH_CONST uint kNormalHemisphere_hemi_octahedral = 1u;

SH_FUNC vec3 encodeNormal_hemi_octahedral(vec3 n, vec3 levels) {
  float s = 1.0f / (abs(n.x) + abs(n.y) + abs(n.z));
  return vec3(unormFromSigned((n.x + n.y) * s, levels.x), unormFromSigned((n.x - n.y) * s, levels.y), 0.0f);
}

SH_FUNC vec3 decodeNormal_hemi_octahedral(vec3 e, vec3 levels) {
  float sum = signedFromUnorm(e.x, levels.x);
  float difference = signedFromUnorm(e.y, levels.y);
  float x = (sum + difference) * 0.5f;
  float y = (sum - difference) * 0.5f;
  return normalize(vec3(x, y, 1.0f - abs(x) - abs(y)));
}

SH_END

#endif
