// The formulas of GTAO, ground-truth ambient occlusion (Jimenez, Wu, Pesce, Jarabo 2016, Practical Realtime Strategies
// for Accurate Indirect Occlusion, Activision technical memo). The hemisphere above a point is divided into slices,
// half planes through the direction to the eye V. In each slice the horizon's angle from V bounds the visible sky, and
// the cosine-weighted arc has a closed form.
#ifndef LATELIGHT_SHARED_AMBIENT_OCCLUSION_H
#define LATELIGHT_SHARED_AMBIENT_OCCLUSION_H

#include "shared/lang.h"
#include "shared/projection.h"

SH_BEGIN

// Weight of an occluder at a distance: 1 nearby, 0 at the radius, smooth in between.
SH_FUNC float occlusionFalloff(float distance, float radius) {
  float x = distance / radius;
  float left = 1.0f - x * x;
  return left > 0.0f ? left * left : 0.0f;
}

// Arc cosine for c in [-1, 1], with an error of at most 7e-5: Abramowitz and Stegun 1964, 4.4.45.
SH_FUNC float quickAcos(float c) {
  float x = abs(c);
  float a = sqrt(max(1.0f - x, 0.0f)) * (1.5707288f + x * (-0.2121144f + x * (0.0742610f - x * 0.0187293f)));
  return c < 0.0f ? kPi - a : a;
}

// The projection of the normal into the plane of a half slice, as an angle n from V, positive toward that half; |n| <=
// pi/2.
struct SliceNormal {
  float angle, cosine, sine;
};

// Cosine-weighted arc from V to the direction at angle h, where c = cos h: the integral of cos(x - n) |sin x| over [0,
// h] (Jimenez et al. 2016, equation 7). For n = 0, the sum over both halves of a slice up to the horizon of a plane is
// 1.
SH_FUNC float visibleArc(SliceNormal n, float c) {
  float s = sqrt(max(1.0f - c * c, 0.0f));
  float cos2 = 2.0f * c * c - 1.0f, sin2 = 2.0f * c * s;
  return 0.25f * (n.cosine - cos2 * n.cosine - sin2 * n.sine + 2.0f * quickAcos(c) * n.sine);
}

// Arc up to the plane perpendicular to the normal, at angle n + pi/2.
SH_FUNC float wholeArc(SliceNormal n) {
  return 0.25f * (2.0f * n.cosine + (2.0f * n.angle + kPi) * n.sine);
}

// True if a direction whose angle from V has cosine c lies above that plane.
SH_FUNC bool abovePlane(SliceNormal n, float c) {
  return c * n.cosine + sqrt(max(1.0f - c * c, 0.0f)) * n.sine > 0.0f;
}

// Unit normal, in view space and toward the viewer, of the plane visible at NDC (x, y) at this device depth, which
// changes by `gradient` per unit of NDC. The result is exact: device depth is an affine function of NDC on any plane.
SH_FUNC vec3 normalFromDepth(Projection p, vec2 ndc, float deviceDepth, vec2 gradient) {
  float x = gradient.x * p.H, z = gradient.y * p.V, y = -p.A;
  if (p.kind == kPerspective) y = deviceDepth - p.A - x * (ndc.x - p.X) / p.H - z * (ndc.y - p.Z) / p.V;
  vec3 n = vec3(x, y, z);
  // The components are as small as device depth; their squares may underflow.
  float most = max(abs(x), max(abs(y), abs(z)));
  // Reversed and conventional depth produce opposite signs.
  vec3 toEye = vec3(0.0f, -1.0f, 0.0f);
  if (p.kind == kPerspective) toEye = vec3((p.X - ndc.x) / p.H, -1.0f, (p.Z - ndc.y) / p.V);
  if (most <= 0.0f) return vec3(0.0f, -1.0f, 0.0f);
  n = n / most;
  float side = dot(n, toEye) < 0.0f ? -1.0f : 1.0f;
  return n * (side * inversesqrt(dot(n, n)));
}

// Difference in device depth of two points `distance` meters apart along the view axis.
SH_FUNC float deviceDepthStep(Projection p, float deviceDepth, float distance) {
  if (p.kind == kOrthographic) return abs(p.A) * distance;
  float inverse = deviceDepth - p.A;  // B / y
  return abs(inverse * (inverse / p.B)) * distance;
}

SH_END

#endif
