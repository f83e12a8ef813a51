// Push constants of finish_sum.comp.
#ifndef LATELIGHT_RENDER_LIGHTING_FINISH_SUM_PUSH_H
#define LATELIGHT_RENDER_LIGHTING_FINISH_SUM_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct FinishSumPush {
  uint64_t frame;  // FrameConstants
};

SH_END

#endif
