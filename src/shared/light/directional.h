// The directional light of KHR_lights_punctual: infinitely far away, so all of its light comes from one direction.
#ifndef LATELIGHT_SHARED_LIGHT_DIRECTIONAL_H
#define LATELIGHT_SHARED_LIGHT_DIRECTIONAL_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_directional "infinitely distant source, in lux"

SH_BEGIN

SH_CONST uint kLightReach_directional = kReachEverywhere;

SH_END

#endif
