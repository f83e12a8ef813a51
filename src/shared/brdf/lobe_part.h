// A part of a lobe that is not round, as a round one of ggx.h: what an environment's maps can be asked for.
#ifndef LATELIGHT_SHARED_BRDF_LOBE_PART_H
#define LATELIGHT_SHARED_BRDF_LOBE_PART_H

#include "shared/lang.h"

SH_BEGIN

struct LobePart {
  vec3 normal;      // unit
  float roughness;  // perceptual
  float weight;     // share of the light that goes to the eye, up to a factor
};

SH_END

#endif
