// What a shader is pushed that finds by itself the surfaces that pixels show (shown_surface.glsl).
#ifndef LATELIGHT_SHOWN_PUSH_H
#define LATELIGHT_SHOWN_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct ShownPush {     // zeros where the layout has targets
  uint64_t instances;  // InstanceList
  uint64_t visible;    // VisibleRef of visible.glsl
};

SH_END

#endif
