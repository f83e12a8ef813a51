#version 460
#extension GL_GOOGLE_include_directive : require
// Motion where nothing is drawn: of the environment, which is infinitely far, so that only the camera's rotation moves it.
#include "render/glsl/common.glsl"
#include "render/visibility/draw_push.h"
#include "shared/motion.h"

layout(push_constant, scalar) uniform Push { DrawPush push; };

layout(location = 0) out vec4 motion;

vec2 motionTo(View view, vec3 here, vec3 direction, uint64_t views) {
  View other = ViewRef(views).v[push.view];
  if (view.projection.kind != kPerspective || other.projection.kind != kPerspective) return vec2(0.0);
  return motionBetween(here, steadyClip(other, other.worldToView * vec4(direction, 0.0)), view.size);
}

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  View view = frameView(frame, push.view);
  vec3 ray = viewRay(view.projection, pixelToNdc(gl_FragCoord.xy, view.size));
  vec3 direction = view.viewToWorld * vec4(ray, 0.0);
  // There and back, as the others go, so that what does not move rounds to nothing.
  vec3 here = steadyClip(view, view.worldToView * vec4(direction, 0.0));
  motion = vec4(motionTo(view, here, direction, frame.previousViews), motionTo(view, here, direction, frame.nextViews));
}
