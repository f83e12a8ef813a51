// A small flat light: its intensity falls with the cosine of the angle to its direction (Lambert 1760), and is zero
// behind it.
#ifndef LATELIGHT_SHARED_LIGHT_LAMBERTIAN_H
#define LATELIGHT_SHARED_LIGHT_LAMBERTIAN_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_lambertian "from a small flat surface, in candela along its normal"

SH_BEGIN

SH_CONST uint kLightReach_lambertian = kReachSphere;

SH_FUNC float lightDistribution_lambertian(Light light, vec3 toLight) {
  return max(-dot(light.direction, toLight), 0.0f);
}

SH_END

#endif
