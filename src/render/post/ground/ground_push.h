// Push constants of ground.comp.
#ifndef LATELIGHT_RENDER_POST_GROUND_PUSH_H
#define LATELIGHT_RENDER_POST_GROUND_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct GroundPush {
  uint64_t frame;      // FrameConstants
  float height;        // of the plane, along Z of the device's world space
  uint first, end;     // samples of this pass
  uint samples;        // of all passes
  uint environment;    // of the pass: its index among the environments of worlds
  uint coversBlended;  // 0: the picture has no background, and blended surfaces in it lie over the plane
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::GroundPush) == 32);
#endif

#endif
