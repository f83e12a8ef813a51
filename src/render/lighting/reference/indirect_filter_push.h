// Push constants of the passes of the indirect light's filter.
#ifndef LATELIGHT_RENDER_LIGHTING_REFERENCE_INDIRECT_FILTER_PUSH_H
#define LATELIGHT_RENDER_LIGHTING_REFERENCE_INDIRECT_FILTER_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct IndirectFilterPush {
  uint64_t frame;  // FrameConstants
  int step;        // distance of the taps, pixels
  uint samples;    // paths per pixel and frame
  uint frames;     // in the history; 0: there is none
  uint padding;
};

SH_END

#endif
