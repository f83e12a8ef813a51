// The spot light of KHR_lights_punctual: a point source with a cone. The intensity is full within the inner half angle
// and zero beyond the outer one.
#ifndef LATELIGHT_SHARED_LIGHT_SPOT_H
#define LATELIGHT_SHARED_LIGHT_SPOT_H

#include "shared/color.h"
#include "shared/types.h"

#define LIGHT_DESCRIPTION_spot "point source with a cone, in candela"

SH_BEGIN

SH_CONST uint kLightReach_spot = kReachCone;

SH_FUNC float lightDistribution_spot(Light light, vec3 toLight) {
  float cone = saturate(-dot(light.direction, toLight) * light.spotScale + light.spotOffset);
  return cone * cone;
}

SH_END

#endif
