// A rectangle that emits light along -Z of its node, as in the draft EXT_lights_area of glTF.
#ifndef LATELIGHT_SHARED_LIGHT_RECT_H
#define LATELIGHT_SHARED_LIGHT_RECT_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_rect "rectangle that emits along -Z, in nits"

SH_BEGIN

SH_CONST uint kLightReach_rect = kReachArea;

SH_END

#endif
