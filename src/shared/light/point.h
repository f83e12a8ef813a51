// The point light of KHR_lights_punctual: equal intensity in all directions.
#ifndef LATELIGHT_SHARED_LIGHT_POINT_H
#define LATELIGHT_SHARED_LIGHT_POINT_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_point "point source in all directions, in candela"

SH_BEGIN

SH_CONST uint kLightReach_point = kReachSphere;

SH_END

#endif
