// Where a surface is, was a frame before and will be a frame after, from scene_motion.vert to fragments: clip x, y and w
// without jitter. They are linear over a triangle as positions are, so what is interpolated is exact. After varyings.glsl.
#ifndef LATELIGHT_MOTION_VARYINGS_GLSL
#define LATELIGHT_MOTION_VARYINGS_GLSL
#include "shared/motion.h"

layout(location = 6) VARYING vec3 varyingNow;
layout(location = 7) VARYING vec3 varyingBefore;
layout(location = 8) VARYING vec3 varyingAfter;

#ifdef VERTEX_STAGE
vec3 clipAt(uint64_t instances, uint64_t views, uint64_t positions, uint instance) {
  mat4x3 toWorld = instanceAt(instances, instance).objectToWorld;
  View view = viewAt(views, push.view);
  vec3 world = toWorld * vec4(positionAt(positions, gl_VertexIndex), 1.0);
  return steadyClip(view, view.worldToView * vec4(world, 1.0));
}

void passMotion(FrameConstants frame, View view, Mesh mesh, vec3 world, uint instance) {
  varyingNow = steadyClip(view, view.worldToView * vec4(world, 1.0));
  varyingBefore = clipAt(frame.previousInstances, frame.previousViews, mesh.previousPositions, instance);
  varyingAfter = clipAt(frame.nextInstances, frame.nextViews, mesh.nextPositions, instance);
}
#else
// xy: to the frame before; zw: to the frame after.
vec4 surfaceMotion(vec2 size) {
  return vec4(motionBetween(varyingNow, varyingBefore, size), motionBetween(varyingNow, varyingAfter, size));
}
#endif

#endif
