// Push constants of visible_motion.comp.
#ifndef LATELIGHT_VISIBLE_MOTION_PUSH_H
#define LATELIGHT_VISIBLE_MOTION_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct VisibleMotionPush {
  uint64_t frame;
  uint64_t instances;
  uint64_t visible;
  uint64_t lenses;  // LensCalibration[3] of the current, previous and next frame; 0: views are projections
};

SH_END

#endif
