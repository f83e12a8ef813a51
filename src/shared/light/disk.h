// A disk that emits light along -Z of its node, as in the draft EXT_lights_area of glTF.
#ifndef LATELIGHT_SHARED_LIGHT_DISK_H
#define LATELIGHT_SHARED_LIGHT_DISK_H

#include "shared/types.h"

#define LIGHT_DESCRIPTION_disk "disk that emits along -Z, in nits"

SH_BEGIN

SH_CONST uint kLightReach_disk = kReachArea;

SH_END

#endif
