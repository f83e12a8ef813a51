// Push constants of interlaced.comp.
#ifndef LATELIGHT_INTERLACED_PUSH_H
#define LATELIGHT_INTERLACED_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

struct FieldPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  uint firstRow;  // 0 or 1
  uint padding;
};

SH_END

#endif
