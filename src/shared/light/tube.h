// A closed cylinder about the X axis of its node, as in UsdLux, whose surface emits light.
#ifndef LATELIGHT_SHARED_LIGHT_TUBE_H
#define LATELIGHT_SHARED_LIGHT_TUBE_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_tube "closed cylinder about X, in nits"

SH_BEGIN

SH_CONST uint kLightReach_tube = kReachArea;

SH_END

#endif
