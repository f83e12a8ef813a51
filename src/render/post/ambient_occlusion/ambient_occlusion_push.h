// Push constants of the ambient occlusion passes.
#ifndef LATELIGHT_RENDER_POST_AMBIENT_OCCLUSION_PUSH_H
#define LATELIGHT_RENDER_POST_AMBIENT_OCCLUSION_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

// Push constants of gtao.glsl.
struct OcclusionPush {
  uint64_t frame;  // FrameConstants
  float radius;    // meters; with worlds, FrameConstants::aoRadius replaces it
  float reach;     // maximum radius in pixels, so that samples are not too far apart
  VisibleSurfacePush shown;
  uint64_t lens;  // LensCalibration of a lens with curved rays; 0: views are projections
  // The point of the lens's aperture from which the view's rays begin, right and up in meters, and the distance at
  // which they meet those of its center.
  vec2 aperture;
  float focus;
  uint padding;
};

// Push constants of ambient_occlusion_denoise.comp.
struct DenoisePush {
  uint64_t frame;   // FrameConstants
  float tolerance;  // meters from the plane at which the weight of a pixel is 0
  float strength;   // exponent of visibility
  float share;      // with worlds, FrameConstants::aoRadius times this replaces `tolerance`
  uint padding;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::OcclusionPush) == 56);
static_assert(sizeof(latelight::shared::DenoisePush) == 24);
#endif

#endif
