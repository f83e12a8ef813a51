// Push constants of emitter_powers.comp and emitter_sums.comp.
#ifndef LATELIGHT_RENDER_LIGHTING_REFERENCE_EMITTERS_PUSH_H
#define LATELIGHT_RENDER_LIGHTING_REFERENCE_EMITTERS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct EmittersPush {
  uint64_t frame;  // FrameConstants
  uint64_t sums;   // float[views][stride]: powers, then their running sums; with worlds, for each view
  uint stride;     // maximum number of emitters
  uint padding;
};

SH_END

#endif
