// The ray of a pixel in world space, between the camera's near and far planes. Include after common.glsl.
#ifndef LATELIGHT_EYE_RAY_GLSL
#define LATELIGHT_EYE_RAY_GLSL
#include "render/glsl/pixel_ray.glsl"
#include "render/glsl/rays.glsl"

// Returns the minimum and maximum depth in meters within the view volume.
vec2 depthsOf(Projection p) {
  if (p.kind == kPerspective) return vec2(p.B / (1.0 - p.A), p.A < 0.0 ? -p.B / p.A : 3.0e38);
  return vec2((1.0 - p.B) / p.A, -p.B / p.A);
}

// Returns the ray through a position in the image, in pixels. It hits nothing if the lens sees nothing there.
Ray rayThrough(FrameConstants frame, View view, vec2 place) {
  vec3 along = pixelRay(frame, view, place), way = toWorldAxes(view, along);
  Ray ray = Ray(view.eye, view.eyeLow, way * inversesqrt(max(dot(way, way), 1e-30)), 0.0, 3.0e38);
  if (along == vec3(0.0)) ray.near = 1.0, ray.far = 0.0;
  if (kLens != 0u) return ray;
  vec2 depths = depthsOf(view.projection);
  if (view.projection.kind != kPerspective) {
    vec3 from = viewPositionAtDepth(view.projection, pixelToNdc(place, view.size), depths.x);
    Exact3 origin = exactSum(view.eye, toWorldAxes(view, from));
    ray.origin = origin.hi;
    ray.originLow += origin.lo;
    depths = vec2(0.0, depths.y - depths.x);
  }
  ray.near = depths.x * length(along);
  ray.far = min(depths.y * length(along), 3.0e38);
  return ray;
}

#endif
