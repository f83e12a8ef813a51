// Push constants of sepia.comp.
#ifndef LATELIGHT_RENDER_POST_SEPIA_PUSH_H
#define LATELIGHT_RENDER_POST_SEPIA_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct SepiaPush {
  float strength;  // 0 to 1
};

SH_END

#endif
