// Push constants of area_shadows.comp.
#ifndef LATELIGHT_RENDER_SHADOW_AREA_SHADOWS_PUSH_H
#define LATELIGHT_RENDER_SHADOW_AREA_SHADOWS_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

struct AreaShadowsPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  uint first, end;  // the area lights of this pass
  uint rays;        // per surface and light
  uint count;       // area lights of all passes
  uint64_t sums;    // LightSumsRef of light_sums.glsl; unused by a pass of all lights
};

SH_END

#endif
