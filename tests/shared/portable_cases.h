// The functions of the headers that are valid GLSL, HLSL and C++: this single list is compiled as all three
// (gpu_math/portable.comp, portable.hlsl, portable_test.cpp), run on the device and the host, and compared.
//
// Cases are numbered: kEncodingCases for each normal encoding, in their order, then those of PORTABLE_CASES. CASE(name,
// relative, absolute, (vec4)): device and host may differ by relative * |host| + absolute in each component.
#ifndef LATELIGHT_TESTS_PORTABLE_CASES_H
#define LATELIGHT_TESTS_PORTABLE_CASES_H

#include "normals.h"
#include "shared/depth_packing.h"
#include "shared/projection.h"

SH_BEGIN

struct PortableArguments {
  vec4 n;   // xyz: unit; w: device depth, from above 0 to below 1
  vec4 c;   // [0, 1]; xyz are multiples of 1 / (2^16 - 1), w is any float
  vec4 w;   // [1e-3, 1e3]
  uvec4 k;  // 32 bits each
};

SH_CONST uint kEncodingCases = 4u;

SH_FUNC vec4 wide(vec3 v) {
  return vec4(v.x, v.y, v.z, 0.0f);
}
SH_FUNC vec3 sameLevels(float levels) {
  return vec3(levels, levels, levels);
}

// 0: float channels. 1: channels of 8 bits; encodings that select among codes may select another one if two are equally
// good, so the error is compared instead. 2 and 3: decoded from 16 bits and from floats.
SH_FUNC vec4 evaluateEncoding(uint encoding, uint part, PortableArguments a) {
  vec3 n = vec3(a.n.x, a.n.y, a.n.z);
  vec3 c = vec3(a.c.x, a.c.y, a.c.z);
  if (part == 0u) return wide(encodeNormal(encoding, n, sameLevels(0.0f)));
  if (part == 1u && encoding != kNormal_octahedral_precise) return wide(encodeNormal(encoding, n, sameLevels(255.0f)));
  if (part == 1u) {
    vec3 e = encodeNormal(encoding, n, sameLevels(255.0f));
    vec3 away = decodeNormal(encoding, e, sameLevels(255.0f)) - n;
    return vec4(length(away), 0.0f, 0.0f, 0.0f);
  }
  return wide(decodeNormal(encoding, c, sameLevels(part == 2u ? 65535.0f : 0.0f)));
}

// Conventional and reversed, finite and infinite, perspective and orthographic, off-center.
SH_FUNC Projection portableProjection(PortableArguments a) {
  float near = 0.1f;
  float far = 60.0f;
  Projection p;
  p.kind = a.k.x & 1u;
  p.H = 0.5f + a.c.x;
  p.V = 0.5f + a.c.y;
  p.X = 0.3f;
  p.Z = -0.2f;
  bool reversed = (a.k.x & 2u) != 0u;
  if (p.kind == kOrthographic) {
    p.A = (reversed ? -1.0f : 1.0f) / (far - near);
    p.B = reversed ? far / (far - near) : -near / (far - near);
  } else if ((a.k.x & 4u) != 0u) {
    p.A = reversed ? 0.0f : 1.0f;
    p.B = reversed ? near : -near;
  } else {
    p.A = reversed ? -near / (far - near) : far / (far - near);
    p.B = (reversed ? far : -near) * (reversed ? near : p.A) / (reversed ? far - near : 1.0f);
  }
  return p;
}

SH_FUNC vec4 positionTimesStep(PortableArguments a, uint method) {
  Projection p = portableProjection(a);
  // Where depth is steep, all digits except the last cancel, so meters are as uncertain as one rounding of the depth.
  float depth = viewDepth(p, a.n.w);
  vec3 v = viewPosition(p, method, vec2(a.n.x, a.n.y), a.n.w);
  float slope = p.kind == kPerspective ? depth * depth / abs(p.B) : 1.0f / abs(p.A);
  return wide(v / (1.0f + abs(depth) + slope));
}

#define PORTABLE_CASES(CASE)                                                                                           \
  CASE(unormFromSigned, 3e-7f, 0.0f, (vec4(unormFromSigned(a.n.x, 255.0f), unormFromSigned(a.n.y, 0.0f), 0.0f, 0.0f))) \
  CASE(signedFromUnorm, 3e-7f, 2e-7f,                                                                                  \
       (vec4(signedFromUnorm(a.c.x, 65535.0f), signedFromUnorm(a.c.y, 0.0f), 0.0f, 0.0f)))                             \
  CASE(packDepth, 2e-7f, 0.0f, (packDepth(uintBitsToFloat(a.k.y & 0x3fffffffu))))                                      \
  CASE(unpackDepth, 0.0f, 0.0f, (vec4(unpackDepth(packDepth(a.c.w)), unpackDepth(packDepth(a.w.x)), 0.0f, 0.0f)))      \
  CASE(packDepthClassic, 0.0f, 2e-7f, (packDepthClassic(a.c.w)))                                                       \
  CASE(unpackDepthClassic, 5e-7f, 0.0f, (vec4(unpackDepthClassic(a.c), 0.0f, 0.0f, 0.0f)))                             \
  CASE(projectToClip, 5e-7f, 5e-4f, (projectToClip(portableProjection(a), vec3(a.n.x, a.n.y, a.n.z) * a.w.x)))         \
  CASE(viewDepth, 5e-6f, 0.0f, (vec4(viewDepth(portableProjection(a), 0.9f * a.n.w), 0.0f, 0.0f, 0.0f)))               \
  CASE(deviceDepth, 5e-7f, 1e-6f, (vec4(deviceDepth(portableProjection(a), a.w.x), 0.0f, 0.0f, 0.0f)))                 \
  CASE(viewPositionAtDepth, 1e-6f, 5e-4f,                                                                              \
       (wide(viewPositionAtDepth(portableProjection(a), vec2(a.n.x, a.n.y), a.w.x))))                                  \
  CASE(viewRay, 1e-6f, 5e-7f, (wide(viewRay(portableProjection(a), vec2(a.n.x, a.n.y)))))                              \
  CASE(inverseProjectionW, 1e-6f, 1e-7f, (inverseProjection(portableProjection(a)).w))                                 \
  CASE(depthTerms, 1e-6f, 1e-7f,                                                                                       \
       (vec4(depthTerms(portableProjection(a)).P, depthTerms(portableProjection(a)).Q, 0.0f, 0.0f)))                   \
  CASE(positionByRay, 1e-6f, 1e-6f, (positionTimesStep(a, kPositionRay)))                                              \
  CASE(positionByMatrix, 1e-6f, 1e-6f, (positionTimesStep(a, kPositionMatrix)))                                        \
  CASE(positionByReciprocal, 1e-6f, 1e-6f, (positionTimesStep(a, kPositionReciprocal)))                                \
  CASE(pixelToNdc, 5e-7f, 5e-7f, (vec4(pixelToNdc(vec2(a.w.x, a.w.y), vec2(640.0f, 480.0f)), 0.0f, 0.0f)))

#define COUNT_PORTABLE(name, id) +1u
SH_CONST uint kPortableEncodings = 0u LATELIGHT_NORMALS(COUNT_PORTABLE);
#undef COUNT_PORTABLE

SH_FUNC vec4 evaluatePortable(uint index, PortableArguments a) {
  uint first = kPortableEncodings * kEncodingCases;
  if (index < first) return evaluateEncoding(index / kEncodingCases, index % kEncodingCases, a);
  uint here = first;
#define EVALUATE_PORTABLE(name, relative, absolute, result) \
  if (index == here) return result;                         \
  here += 1u;
  PORTABLE_CASES(EVALUATE_PORTABLE)
#undef EVALUATE_PORTABLE
  return vec4(0.0f, 0.0f, 0.0f, 0.0f);
}

SH_END

#endif
