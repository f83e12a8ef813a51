// Push constants of accumulate.comp.
#ifndef LATELIGHT_RENDER_POST_ACCUMULATE_PUSH_H
#define LATELIGHT_RENDER_POST_ACCUMULATE_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct AccumulatePush {
  uint first;  // 1: the sum is still empty
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::AccumulatePush) == 4);
#endif

#endif
