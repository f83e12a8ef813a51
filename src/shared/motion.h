// Motion vectors: the displacement of a point on screen between two frames, in pixels, without jitter, y down.
#ifndef LATELIGHT_SHARED_MOTION_H
#define LATELIGHT_SHARED_MOTION_H

#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

// Clip x, y and w of a view-space position, from the view's projection without its jitter.
SH_FUNC vec3 steadyClip(View view, vec3 position) {
  vec4 clip = projectToClip(view.projection, position);
  return vec3(clip.x - view.jitter.x * clip.w, clip.y - view.jitter.y * clip.w, clip.w);
}

// Motion from one such position to another. It is zero if either position is behind the camera, and therefore not on
// screen, or if the result overflows: NaN fails every comparison.
SH_FUNC vec2 motionBetween(vec3 from, vec3 to, vec2 size) {
  vec2 way = vec2((to.x / to.z - from.x / from.z) * 0.5f * size.x, (from.y / from.z - to.y / to.z) * 0.5f * size.y);
  bool known = to.z > 0.0f && from.z > 0.0f && abs(way.x) < 3.0e38f && abs(way.y) < 3.0e38f;
  return vec2(known ? way.x : 0.0f, known ? way.y : 0.0f);
}

SH_END

#endif
