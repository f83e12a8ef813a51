// Projection and its inverse. View space is right-handed, with X right, Y away from the viewer and Z up, as in Blender
// and CryEngine. View depth is Y.
//
// A projection consists of {H, V, A, B} and a principal point:
//
//   perspective    clip = (H x + X y, V z + Z y, A y + B, y)
//   orthographic   clip = (H x + X,   V z + Z,   A y + B, 1)
//
// Device depth is clip.z / clip.w in [0, 1]. Conventional, reversed (reversed-Z) and infinite depth differ only in A
// and B. X and Z are the principal point in NDC. NDC has y up; pixel rows run down.
#ifndef LATELIGHT_SHARED_PROJECTION_H
#define LATELIGHT_SHARED_PROJECTION_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kPerspective = 0u;
SH_CONST uint kOrthographic = 1u;

struct Projection {
  float H, V;  // horizontal and vertical scale: 1 / tan(half angle), or 1 / half extent in meters
  float A, B;  // device depth = A + B / y (perspective) or A y + B (orthographic)
  float X, Z;  // principal point offset, NDC
  uint kind;   // kPerspective or kOrthographic
};

// View-space position (meters) to homogeneous clip space.
SH_FUNC vec4 projectToClip(Projection p, vec3 v) {
  float w = p.kind == kPerspective ? v.y : 1.0f;
  return vec4(p.H * v.x + p.X * w, p.V * v.z + p.Z * w, p.A * v.y + p.B, w);
}

// View depth (meters along Y) of a device depth. Infinite at the far plane of an infinite projection.
SH_FUNC float viewDepth(Projection p, float deviceDepth) {
  return p.kind == kPerspective ? p.B / (deviceDepth - p.A) : (deviceDepth - p.B) / p.A;
}

// Device depth of a view depth: the inverse of viewDepth.
SH_FUNC float deviceDepth(Projection p, float depth) {
  return p.kind == kPerspective ? p.A + p.B / depth : p.A * depth + p.B;
}

// View-space position of the point at `depth` meters along Y whose NDC is (x, y).
SH_FUNC vec3 viewPositionAtDepth(Projection p, vec2 ndc, float depth) {
  float w = p.kind == kPerspective ? depth : 1.0f;
  return vec3((ndc.x - p.X) * w / p.H, depth, (ndc.y - p.Z) * w / p.V);
}

// --- position from depth, three methods -----------------------------------------------------------------------------

SH_CONST uint kPositionRay = 0u;         // the view ray times view depth B / (d - A)
SH_CONST uint kPositionMatrix = 1u;      // the full inverse matrix, and the division by w
SH_CONST uint kPositionReciprocal = 2u;  // the view ray times 1 / (P d + Q)

// The inverse projection matrix by columns. It has no matrix type, because matrix products differ between languages.
// Every invertible projection has an inverse matrix; inverseProjection() writes out the one of this kind of projection.
struct InverseProjection {
  vec4 x, y, z, w;  // factors of NDC x, NDC y, device depth and 1; the sum is view-space (x, y, z) w, and w
};

SH_FUNC InverseProjection inverseProjection(Projection p) {
  InverseProjection m;
  m.x = vec4(1.0f / p.H, 0.0f, 0.0f, 0.0f);
  m.y = vec4(0.0f, 0.0f, 1.0f / p.V, 0.0f);
  if (p.kind == kPerspective) {
    m.z = vec4(0.0f, 0.0f, 0.0f, 1.0f / p.B);
    m.w = vec4(-p.X / p.H, 1.0f, -p.Z / p.V, -p.A / p.B);
  } else {
    m.z = vec4(0.0f, 1.0f / p.A, 0.0f, 0.0f);
    m.w = vec4(-p.X / p.H, -p.B / p.A, -p.Z / p.V, 1.0f);
  }
  return m;
}

SH_FUNC vec3 viewPositionByMatrix(InverseProjection m, vec2 ndc, float deviceDepth) {
  vec4 h = m.x * ndc.x + m.y * ndc.y + m.z * deviceDepth + m.w;
  return vec3(h.x / h.w, h.y / h.w, h.z / h.w);
}

// View depth as one multiply-add, P d + Q, followed by a reciprocal for perspective projections.
struct DepthTerms {
  float P, Q;
};

// P = 1 / B and Q = -A / B are entries of the inverse matrix. Orthographic depth is linear and needs no reciprocal: P =
// 1 / A and Q = -B / A.
SH_FUNC DepthTerms depthTerms(Projection p) {
  float scale = 1.0f / (p.kind == kPerspective ? p.B : p.A);
  DepthTerms t;
  t.P = scale;
  t.Q = -(p.kind == kPerspective ? p.A : p.B) * scale;
  return t;
}

SH_FUNC float viewDepthByReciprocal(Projection p, DepthTerms t, float deviceDepth) {
  float sum = deviceDepth * t.P + t.Q;
  return p.kind == kPerspective ? 1.0f / sum : sum;
}

// View-space position of the point at NDC (x, y) with this device depth; `method` is kPosition*.
SH_FUNC vec3 viewPosition(Projection p, uint method, vec2 ndc, float deviceDepth) {
  if (method == kPositionMatrix) return viewPositionByMatrix(inverseProjection(p), ndc, deviceDepth);
  float depth =
      method == kPositionReciprocal ? viewDepthByReciprocal(p, depthTerms(p), deviceDepth) : viewDepth(p, deviceDepth);
  return viewPositionAtDepth(p, ndc, depth);
}

// View-space direction of the ray through NDC (x, y), not normalized: its Y is 1.
SH_FUNC vec3 viewRay(Projection p, vec2 ndc) {
  if (p.kind == kPerspective) return vec3((ndc.x - p.X) / p.H, 1.0f, (ndc.y - p.Z) / p.V);
  return vec3(0.0f, 1.0f, 0.0f);
}

// NDC (y up) of a pixel coordinate (y down; pixel centers at .5) in an image of `size` pixels.
SH_FUNC vec2 pixelToNdc(vec2 pixel, vec2 size) {
  return vec2(2.0f * pixel.x / size.x - 1.0f, 1.0f - 2.0f * pixel.y / size.y);
}

SH_END

#endif
