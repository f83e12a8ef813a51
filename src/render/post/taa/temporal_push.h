// Push constants of taa.comp.
#ifndef LATELIGHT_RENDER_POST_TEMPORAL_PUSH_H
#define LATELIGHT_RENDER_POST_TEMPORAL_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct TemporalPush {
  uint64_t frame;  // FrameConstants
  float scale;     // factor for the picture: 1 / frames in the sum
  float samples;   // in the sum, if a history begins; 0 if it continues
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::TemporalPush) == 16);
#endif

#endif
