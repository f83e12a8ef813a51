// Push constants of ray_shadows.comp.
#ifndef LATELIGHT_RENDER_SHADOW_RAY_SHADOWS_PUSH_H
#define LATELIGHT_RENDER_SHADOW_RAY_SHADOWS_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

struct RayShadowsPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  uint first, end;  // columns of FrameConstants::shadowMaps: the lights of this pass
  uint viewStride;  // elements of FrameConstants::shadowMaps from one view to the next; 0: all views have the same
  uint count;       // columns of all passes
  uint64_t sums;    // LightSumsRef of light_sums.glsl; unused by a pass of all columns
};

SH_END

#endif
