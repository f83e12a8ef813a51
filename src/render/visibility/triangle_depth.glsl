// The device depth of a triangle at a position in the image, from the plane of the triangle. The visibility buffer is
// filled with these depths by rasterization and by rays alike. Include after common.glsl.
#ifndef LATELIGHT_TRIANGLE_DEPTH_GLSL
#define LATELIGHT_TRIANGLE_DEPTH_GLSL
#include "render/visibility/compute/raster_push.h"

// `placed` is relativeToEye().
vec3 seenPosition(View view, mat4x3 placed, vec3 position) {
  precise vec3 relative = placed * vec4(position, 1.0);
  precise vec3 seen = mat3(view.worldToView) * relative;
  return seen;
}

vec4 clipPosition(View view, vec3 seen) {
  precise vec4 clip = projectToClip(view.projection, seen);
  return clip;
}

float deviceDepthOf(vec4 clip) {
  precise float inverse = 1.0 / clip.w;
  precise float depth = clip.z * inverse;
  return clamp(depth, 0.0, 1.0);
}

// Returns the depth plane (LargeTriangle::plane) of the points p in view space with dot(n, p) = d.
vec3 depthPlane(Projection p, vec3 n, float d) {
  if (p.kind == kPerspective) {
    precise float inverse = 1.0 / d;  // B last: if it is a power of two, rounding is independent of the near plane
    precise vec3 plane = n * inverse * p.B;
    return vec3(plane.x, plane.y + p.A, plane.z);
  }
  precise float tilt = p.A / n.y;
  return vec3(-tilt * n.x, p.B + tilt * d, -tilt * n.z);
}

// Returns the depth plane of the triangle itself, not of the snapped one, because on surfaces at grazing angles one
// subpixel changes the depth by a lot. Corners are in view space.
vec3 depthPlane(View view, vec3 a, vec3 b, vec3 c) {
  Projection p = view.projection;
  vec3 ab = b - a, ac = c - a;
  vec3 extent = max(abs(ab), abs(ac));
  float scale = 1.0 / max(max(extent.x, max(extent.y, extent.z)), 1e-37);
  precise vec3 n = cross(ab * scale, ac * scale);
  precise float d = dot(n, a);
  return depthPlane(p, n, d);
}

// Returns the depth gradient per pixel to the right and down.
vec2 depthSteps(View view, vec3 plane) {
  return vec2(2.0 * plane.x / (view.projection.H * view.size.x), -2.0 * plane.z / (view.projection.V * view.size.y));
}

// Returns x and z of the ray through a position in the image, in pixels.
vec2 rayAt(View view, vec2 place) {
  vec2 ndc = pixelToNdc(place, view.size);
  precise vec2 ray = (ndc - vec2(view.projection.X, view.projection.Z)) / vec2(view.projection.H, view.projection.V);
  return ray;
}
float depthOn(vec3 plane, vec2 ray) {
  precise float depth = plane.x * ray.x + plane.y + plane.z * ray.y;
  return depth;
}

// Returns the minimum and maximum depth of a triangle's pixels: the range of its corners, extended by the plane's slope
// over one subpixel, because snapping lets a triangle cover pixels slightly outside of it. A plane seen edge-on yields
// arbitrary depths, which are clamped to a corner's.
vec2 depthRange(View view, vec3 plane, float least, float most) {
  vec2 steps = abs(depthSteps(view, plane));
  float more = min((steps.x + steps.y) / float(kSubpixels), most - least);
  more = more >= 0.0 ? more : most - least;  // NaN
  return vec2(max(least - more, 0.0), min(most + more, 1.0));
}
float withinRange(float least, float most, float depth) { return clamp(depth >= 0.0 ? depth : least, least, most); }

#endif
