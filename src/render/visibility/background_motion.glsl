// Motion where nothing is drawn: of the environment, which is infinitely far, so that only the camera's rotation moves it.
#include "shared/motion.h"

vec2 backgroundMotionTo(View view, View other, vec3 here, vec3 direction) {
  if (view.projection.kind != kPerspective || other.projection.kind != kPerspective) return vec2(0.0);
  return motionBetween(here, steadyClip(other, other.worldToView * vec4(direction, 0.0)), view.size);
}

// xy: to the frame before; zw: to the frame after.
vec4 backgroundMotion(FrameConstants frame, View view, uint viewIndex, vec2 pixel) {
  vec3 ray = viewRay(view.projection, pixelToNdc(pixel, view.size));
  vec3 direction = view.viewToWorld * vec4(ray, 0.0);
  // There and back, as the others go, so that what does not move rounds to nothing.
  vec3 here = steadyClip(view, view.worldToView * vec4(direction, 0.0));
  return vec4(backgroundMotionTo(view, viewAt(frame.previousViews, viewIndex), here, direction),
              backgroundMotionTo(view, viewAt(frame.nextViews, viewIndex), here, direction));
}
