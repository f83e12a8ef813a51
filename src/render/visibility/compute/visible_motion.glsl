// Motion vectors of the visible surface. Include after surface_point.glsl.
#include "shared/motion.h"

// `placed` is relativeToEye().
vec3 clipOf(View view, mat4x3 placed, uint64_t positions, uint vertex) {
  return steadyClip(view, toView(view, placed * vec4(positionAt(positions, vertex), 1.0)));
}

bool samePlace(Instance a, Instance b) {
  return a.objectToWorld == b.objectToWorld && a.translationLow == b.translationLow;
}

// Returns the point's distance from the eye in the previous frame, divided by that in this frame.
float seenApproach(FrameConstants frame, View view, uint viewIndex, VisibleTriangle t, vec2 pixel) {
  View viewBefore = viewAt(frame.previousViews, viewIndex);
  mat4x3 before = relativeToEye(instanceAt(frame.previousInstances, t.draw.instance), viewBefore);
  Mesh mesh = frameMesh(frame, t.draw.mesh);
  vec3 corners[3] = cornersOf(frame, view, t), now = vec3(0.0), past = vec3(0.0);
  Weights w = weightsAt(frame, view, corners[0], corners[1], corners[2], pixel);
  for (int i = 0; i < 3; ++i) {
    now += w.at[i] * corners[i];
    past += w.at[i] * (before * vec4(positionAt(mesh.previousPositions, t.indices[i]), 1.0));
  }
  if (isVast(t)) {
    now = vastPoint(frame, view, vastCornersOf(frame, view, t), pixel);
    past = toWorldAxes(view, now) + eyeBetween(viewBefore, view);
  }
  return length(past) / max(length(now), 1e-20);
}

// Returns motion vectors, in pixels: xy to the previous frame, zw to the next frame.
vec4 seenMotion(FrameConstants frame, View view, uint viewIndex, VisibleTriangle t, vec2 pixel) {
  View viewBefore = viewAt(frame.previousViews, viewIndex), viewAfter = viewAt(frame.nextViews, viewIndex);
  mat4x3 now = relativeToEye(frameInstance(frame, t.draw.instance), view);
  mat4x3 before = relativeToEye(instanceAt(frame.previousInstances, t.draw.instance), viewBefore);
  mat4x3 after = relativeToEye(instanceAt(frame.nextInstances, t.draw.instance), viewAfter);
  Mesh mesh = frameMesh(frame, t.draw.mesh);
  vec3 corners[3], clipNow = vec3(0.0), clipBefore = vec3(0.0), clipAfter = vec3(0.0);
  for (int i = 0; i < 3; ++i)
    corners[i] = toView(view, now * vec4(positionAt(mesh.positions, t.indices[i]), 1.0));
  Weights w = weightsAt(frame, view, corners[0], corners[1], corners[2], pixel);
  for (int i = 0; i < 3; ++i) {
    clipNow += w.at[i] * clipOf(view, now, mesh.positions, t.indices[i]);
    clipBefore += w.at[i] * clipOf(viewBefore, before, mesh.previousPositions, t.indices[i]);
    clipAfter += w.at[i] * clipOf(viewAfter, after, mesh.nextPositions, t.indices[i]);
  }
  // If a vast triangle is static, its motion follows only from the eye positions, which are known exactly.
  Instance current = frameInstance(frame, t.draw.instance);
  if (isVast(t) && samePlace(current, instanceAt(frame.previousInstances, t.draw.instance)) &&
      samePlace(current, instanceAt(frame.nextInstances, t.draw.instance))) {
    vec3 seen = vastPoint(frame, view, vastCornersOf(frame, view, t), pixel);
    vec3 relative = toWorldAxes(view, seen);
    clipNow = steadyClip(view, seen);
    clipBefore = steadyClip(viewBefore, toView(viewBefore, relative + eyeBetween(viewBefore, view)));
    clipAfter = steadyClip(viewAfter, toView(viewAfter, relative + eyeBetween(viewAfter, view)));
  }
  return vec4(motionBetween(clipNow, clipBefore, view.size), motionBetween(clipNow, clipAfter, view.size));
}
