// Push constants of shaders that evaluate visible surfaces from the visibility buffer (visible_surface.glsl).
#ifndef LATELIGHT_SHOWN_PUSH_H
#define LATELIGHT_SHOWN_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct VisibleSurfacePush {  // zeros if the layout has targets
  uint64_t instances;        // InstanceList
  uint64_t visible;          // VisibleRef of visible.glsl
};

SH_END

#endif
