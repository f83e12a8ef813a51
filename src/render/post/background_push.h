// Push constants of background.comp.
#ifndef LATELIGHT_RENDER_POST_BACKGROUND_PUSH_H
#define LATELIGHT_RENDER_POST_BACKGROUND_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct BackgroundPush {
  uint64_t frame;    // FrameConstants
  uint environment;  // with worlds: the layer of the environment; other views are skipped
  uint padding;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::BackgroundPush) == 16);
#endif

#endif
