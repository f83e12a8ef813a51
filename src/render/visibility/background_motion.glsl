// Motion vectors of the background. The environment is infinitely far away, so only the camera's rotation moves it.
#include "shared/motion.h"

vec2 backgroundMotionTo(View view, View other, vec3 here, vec3 direction) {
  if (view.projection.kind != kPerspective || other.projection.kind != kPerspective) return vec2(0.0);
  return motionBetween(here, steadyClip(other, other.worldToView * vec4(direction, 0.0)), view.size);
}

// Returns motion vectors, in pixels: xy to the previous frame, zw to the next frame.
vec4 backgroundMotion(FrameConstants frame, View view, uint viewIndex, vec2 pixel) {
  vec3 ray = viewRay(view.projection, pixelToNdc(pixel, view.size));
  vec3 direction = view.viewToWorld * vec4(ray, 0.0);
  // Transform to world space and back, as for the other frames, so that rounding cancels when nothing moves.
  vec3 here = steadyClip(view, view.worldToView * vec4(direction, 0.0));
  return vec4(backgroundMotionTo(view, viewAt(frame.previousViews, viewIndex), here, direction),
              backgroundMotionTo(view, viewAt(frame.nextViews, viewIndex), here, direction));
}
