// What interlaced.comp is pushed.
#ifndef LATELIGHT_INTERLACED_PUSH_H
#define LATELIGHT_INTERLACED_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct FieldPush {
  uint64_t frame;  // FrameConstants
  uint firstRow;   // 0 or 1
};

SH_END

#endif
