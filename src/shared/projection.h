// Projection and its inverse, in the coordinate system of the engine notes (seed 004): right-handed, X right, Y away
// from the viewer, Z up. View depth is Y.
//
// The matrix is nothing but {H, V, A, B} and a principal point:
//
//   perspective    clip = (H x + X y, V z + Z y, A y + B, y)
//   orthographic   clip = (H x + X,   V z + Z,   A y + B, 1)
//
// Device depth is clip.z / clip.w in [0, 1]. Conventional, reversed and infinite depth are values of A and B; so is the
// off-centre principal point a value of X and Z (in NDC). NDC is y up; pixel rows run down.
#ifndef LATELIGHT_SHARED_PROJECTION_H
#define LATELIGHT_SHARED_PROJECTION_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kPerspective = 0u;
SH_CONST uint kOrthographic = 1u;

struct Projection {
  float H, V;  // horizontal and vertical scale: 1 / tan(half angle), or 1 / half extent in metres
  float A, B;  // device depth = A + B / y (perspective) or A y + B (orthographic)
  float X, Z;  // principal point offset, NDC
  uint kind;   // kPerspective or kOrthographic
};

// View-space position (metres) to homogeneous clip space.
SH_FUNC vec4 projectToClip(Projection p, vec3 v) {
  float w = p.kind == kPerspective ? v.y : 1.0f;
  return vec4(p.H * v.x + p.X * w, p.V * v.z + p.Z * w, p.A * v.y + p.B, w);
}

// View depth (metres along Y) of a device depth. Infinite for the far plane of an infinite projection.
SH_FUNC float viewDepth(Projection p, float deviceDepth) {
  return p.kind == kPerspective ? p.B / (deviceDepth - p.A) : (deviceDepth - p.B) / p.A;
}

// Device depth of a view depth: the inverse of viewDepth.
SH_FUNC float deviceDepth(Projection p, float depth) {
  return p.kind == kPerspective ? p.A + p.B / depth : p.A * depth + p.B;
}

// View-space position of the point at `depth` metres along Y seen at NDC (x, y).
SH_FUNC vec3 viewPositionAtDepth(Projection p, vec2 ndc, float depth) {
  float w = p.kind == kPerspective ? depth : 1.0f;
  return vec3((ndc.x - p.X) * w / p.H, depth, (ndc.y - p.Z) * w / p.V);
}

// View-space direction, not normalised (its Y is 1), of the ray through NDC (x, y).
SH_FUNC vec3 viewRay(Projection p, vec2 ndc) {
  if (p.kind == kPerspective) return vec3((ndc.x - p.X) / p.H, 1.0f, (ndc.y - p.Z) / p.V);
  return vec3(0.0f, 1.0f, 0.0f);
}

// NDC (y up) of a pixel coordinate (y down; pixel centres at .5) in a picture of `size` pixels.
SH_FUNC vec2 pixelToNdc(vec2 pixel, vec2 size) {
  return vec2(2.0f * pixel.x / size.x - 1.0f, 1.0f - 2.0f * pixel.y / size.y);
}

SH_END

#endif
