// Where something is seen in one frame and in another: motion, in pixels without jitter, y down.
#ifndef LATELIGHT_SHARED_MOTION_H
#define LATELIGHT_SHARED_MOTION_H

#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

// Clip x, y and w of a view-space position, by the view's projection less its jitter.
SH_FUNC vec3 steadyClip(View view, vec3 position) {
  vec4 clip = projectToClip(view.projection, position);
  return vec3(clip.x - view.jitter.x * clip.w, clip.y - view.jitter.y * clip.w, clip.w);
}

// From one such place to another. Nothing where the other is behind the camera, and so nowhere on the picture.
SH_FUNC vec2 motionBetween(vec3 from, vec3 to, vec2 size) {
  if (to.z <= 0.0f || from.z <= 0.0f) return vec2(0.0f, 0.0f);
  return vec2((to.x / to.z - from.x / from.z) * 0.5f * size.x, (from.y / from.z - to.y / to.z) * 0.5f * size.y);
}

SH_END

#endif
