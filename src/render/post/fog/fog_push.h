// Push constants of fog.comp.
#ifndef LATELIGHT_RENDER_POST_FOG_PUSH_H
#define LATELIGHT_RENDER_POST_FOG_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct FogPush {
  uint64_t frame;  // FrameConstants
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::FogPush) == 8);
#endif

#endif
