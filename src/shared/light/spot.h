// KHR_lights_punctual's spot light: from a point into a cone, all of it within the inner half angle, and none from the
// outer one on.
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
