// Push constants of the passes of ambient occlusion.
#ifndef LATELIGHT_RENDER_POST_AMBIENT_OCCLUSION_PUSH_H
#define LATELIGHT_RENDER_POST_AMBIENT_OCCLUSION_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

// Of gtao.glsl.
struct OcclusionPush {
  uint64_t frame;  // FrameConstants
  float radius;    // metres
  float reach;     // pixels, at most: keeps samples from being too far apart
  ShownPush shown;
};

// Of ambient_occlusion_denoise.comp.
struct DenoisePush {
  uint64_t frame;   // FrameConstants
  float tolerance;  // metres off the plane at which a pixel no longer counts
  float strength;   // exponent
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::OcclusionPush) == 32);
static_assert(sizeof(latelight::shared::DenoisePush) == 16);
#endif

#endif
