// Push constants of layered.comp.
#ifndef LATELIGHT_LAYERED_PUSH_H
#define LATELIGHT_LAYERED_PUSH_H

#include "render/lighting/lighting_push.h"

SH_BEGIN

struct LayeredPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  LightCells lists;  // of the lighting technique; not read if there are none
};

SH_END

#endif
