// Push constants of sun_mark.frag and sun_occlusion.frag.
#ifndef LATELIGHT_SUN_PUSH_H
#define LATELIGHT_SUN_PUSH_H

#include "shared/types.h"

SH_BEGIN

struct SunPush {
  uint64_t frame;  // FrameConstants
  uint view;
  LightShadow shadow;
  Light sun;
};

SH_END

#endif
