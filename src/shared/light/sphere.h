// A sphere whose surface emits light.
#ifndef LATELIGHT_SHARED_LIGHT_SPHERE_H
#define LATELIGHT_SHARED_LIGHT_SPHERE_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_sphere "sphere, in nits"

SH_BEGIN

SH_CONST uint kLightReach_sphere = kReachArea;

SH_END

#endif
