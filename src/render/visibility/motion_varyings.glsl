// A surface's clip positions in the current, previous and next frame, from scene_motion.vert to fragment shaders: clip
// x, y and w without jitter; and its position in the previous frame's view space. They are linear over a triangle, as
// positions are, so interpolation is exact. Include after varyings.glsl.
#ifndef LATELIGHT_MOTION_VARYINGS_GLSL
#define LATELIGHT_MOTION_VARYINGS_GLSL
#include "shared/motion.h"

layout(location = 6) VARYING vec3 varyingNow;
layout(location = 7) VARYING vec3 varyingBefore;
layout(location = 8) VARYING vec3 varyingAfter;
layout(location = 11) VARYING vec3 varyingSeenBefore;

#ifdef VERTEX_STAGE
vec3 seenAt(View view, uint64_t instances, uint64_t positions, uint instance) {
  mat4x3 placed = relativeToEye(instanceAt(instances, instance), view);
  return toView(view, placed * vec4(positionAt(positions, gl_VertexIndex), 1.0));
}

void passMotion(FrameConstants frame, View view, Mesh mesh, vec3 relative, uint instance) {
  View before = viewAt(frame.previousViews, push.view), after = viewAt(frame.nextViews, push.view);
  varyingSeenBefore = seenAt(before, frame.previousInstances, mesh.previousPositions, instance);
  varyingNow = steadyClip(view, toView(view, relative));
  varyingBefore = steadyClip(before, varyingSeenBefore);
  varyingAfter = steadyClip(after, seenAt(after, frame.nextInstances, mesh.nextPositions, instance));
}

// A vast triangle counts as static. Its motion follows only from the eye positions, which are known exactly.
void passVastMotion(FrameConstants frame, View view, vec3 relative) {
  View before = viewAt(frame.previousViews, push.view), after = viewAt(frame.nextViews, push.view);
  varyingSeenBefore = toView(before, relative + eyeBetween(before, view));
  varyingNow = steadyClip(view, toView(view, relative));
  varyingBefore = steadyClip(before, varyingSeenBefore);
  varyingAfter = steadyClip(after, toView(after, relative + eyeBetween(after, view)));
}
#else
// Returns motion vectors, in pixels: xy to the previous frame, zw to the next frame.
vec4 surfaceMotion(vec2 size) {
  return vec4(motionBetween(varyingNow, varyingBefore, size), motionBetween(varyingNow, varyingAfter, size));
}
#endif

#endif
