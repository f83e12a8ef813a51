// Push constants of light_bound.comp.
#ifndef LATELIGHT_STUDY_LIGHT_BOUND_PUSH_H
#define LATELIGHT_STUDY_LIGHT_BOUND_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/types.h"

SH_BEGIN

struct LightBoundPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  Light light;  // properties that all synthetic lights share
  vec3 apart;   // offset in meters from one light to the next
  uint lights;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::LightBoundPush) == 104);
#endif

#endif
