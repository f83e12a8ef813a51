// Motion vectors through a lens that bends rays: the positions of a point in the current, previous and next frame are
// projected through the lenses of these frames. Include after visible_motion.glsl.
#include "render/glsl/lens_calibration.glsl"

LensPoint lensPoint(uint time, vec3 inView) {
  return projectFromView(LensCalibrationRef(push.lenses).v[time], inView);
}

vec4 lensMotionBetween(vec3 now, vec3 before, vec3 after) {
  LensCalibration lens = LensCalibrationRef(push.lenses).v[0];
  LensPoint from = lensPoint(0u, now);
  return vec4(motionThroughLens(lens, from, lensPoint(1u, before)),
              motionThroughLens(lens, from, lensPoint(2u, after)));
}

// Returns motion vectors, in pixels: xy to the previous frame, zw to the next frame.
vec4 seenLensMotion(FrameConstants frame, View view, uint viewIndex, VisibleTriangle t, vec2 pixel) {
  View viewBefore = viewAt(frame.previousViews, viewIndex), viewAfter = viewAt(frame.nextViews, viewIndex);
  mat4x3 now = relativeToEye(frameInstance(frame, t.draw.instance), view);
  mat4x3 before = relativeToEye(instanceAt(frame.previousInstances, t.draw.instance), viewBefore);
  mat4x3 after = relativeToEye(instanceAt(frame.nextInstances, t.draw.instance), viewAfter);
  Mesh mesh = frameMesh(frame, t.draw.mesh);
  vec3 corners[3], seenNow = vec3(0.0), seenBefore = vec3(0.0), seenAfter = vec3(0.0);
  for (int i = 0; i < 3; ++i)
    corners[i] = toView(view, now * vec4(positionAt(mesh.positions, t.indices[i]), 1.0));
  Weights w = weightsAt(frame, view, corners[0], corners[1], corners[2], pixel);
  for (int i = 0; i < 3; ++i) {
    seenNow += w.at[i] * corners[i];
    seenBefore += w.at[i] * toView(viewBefore, before * vec4(positionAt(mesh.previousPositions, t.indices[i]), 1.0));
    seenAfter += w.at[i] * toView(viewAfter, after * vec4(positionAt(mesh.nextPositions, t.indices[i]), 1.0));
  }
  return lensMotionBetween(seenNow, seenBefore, seenAfter);
}

// The environment is infinitely far away, so only the camera's rotation moves it. Pixels without a ray do not move.
vec4 backgroundLensMotion(FrameConstants frame, View view, uint viewIndex, ivec2 pixel) {
  vec3 ray = lensRay(frame, view, pixel).direction;
  if (ray == vec3(0.0)) return vec4(0.0);
  View before = viewAt(frame.previousViews, viewIndex), after = viewAt(frame.nextViews, viewIndex);
  vec3 direction = view.viewToWorld * vec4(ray, 0.0);
  // Transform to world space and back, as for the other frames, so that rounding cancels when nothing moves.
  return lensMotionBetween(view.worldToView * vec4(direction, 0.0), before.worldToView * vec4(direction, 0.0),
                           after.worldToView * vec4(direction, 0.0));
}
