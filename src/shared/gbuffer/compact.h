// compact, the default: lighting matches lighting from floats to within one 8-bit level. 20 bytes per pixel, including
// depth.
//
// Relative errors matter, not absolute ones: a lobe's peak is proportional to 1 / roughness^4, and a strong light makes
// a dark color bright. Therefore colors, roughness and reflectance are stored as square roots, whose steps shrink
// toward 0, and metalness has small steps at both ends. Normals have the most bits: the highlight of the smoothest
// surface is 1e-3 radians wide (kGgxMinAlpha), and an error of 5e-6 changes its flank by 1 %.
#ifndef LATELIGHT_SHARED_GBUFFER_COMPACT_H
#define LATELIGHT_SHARED_GBUFFER_COMPACT_H

#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION "matches floats to one 8-bit level, in 20 bytes per pixel with depth; the default"
#define GBUFFER_TARGETS(T)                                                                                          \
  T(0, surface, R32G32B32A32_UINT, uvec4,                                                                           \
    "r: world normal 32 of 40 (20+20 or 13+13+13); g: normal 8, roughness 12, metallic 10, reflectance 2; b: base " \
    "color 10+10+10, reflectance 2; a: reflectance 24, grazing reflectance 8")

GBUFFER_BEGIN

// Quantizes the square root of a value in [0, 1], and back.
SH_FUNC uint rootBits(float x, uint bits) {
  return toBits(sqrt(saturate(x)), bits);
}
SH_FUNC float fromRootBits(uint x, uint bits) {
  float root = fromBits(x, bits);
  return root * root;
}

// Stores metalness as the square root of half its distance to the nearer end: near-metals keep their little diffuse
// light, and near-dielectrics their reflectance.
SH_FUNC uint packMetallic(float m) {
  return toBits(m <= 0.5f ? sqrt(max(m, 0.0f) * 0.5f) : 1.0f - sqrt(max(1.0f - m, 0.0f) * 0.5f), 10u);
}
SH_FUNC float unpackMetallic(uint x) {
  float root = fromBits(x, 10u);
  return root <= 0.5f ? 2.0f * root * root : 1.0f - 2.0f * (1.0f - root) * (1.0f - root);
}

// Packs a normal into 40 bits, 32 and 8.
SH_FUNC vec3 normal40Levels(bool two) {
  float levels = two ? 1048575.0f : 8191.0f;
  return vec3(levels, levels, levels);
}
SH_FUNC uvec2 packNormal40(uint encoding, vec3 n) {
  bool two = normalChannels(encoding) == 2u;
  uint bits = two ? 20u : 13u;
  vec3 e = encodeNormal(encoding, n, normal40Levels(two));
  uint x = toBits(e.x, bits), y = toBits(e.y, bits), z = two ? 0u : toBits(e.z, bits);
  return two ? uvec2(x | (y << 20u), y >> 12u) : uvec2(x | (y << 13u) | (z << 26u), z >> 6u);
}
SH_FUNC vec3 unpackNormal40(uint encoding, uint low, uint high) {
  bool two = normalChannels(encoding) == 2u;
  uint bits = two ? 20u : 13u;
  uint y = two ? (low >> 20u) | (high << 12u) : low >> 13u;
  uint z = two ? 0u : (low >> 26u) | (high << 6u);
  return decodeNormal(encoding, vec3(fromBits(low, bits), fromBits(y, bits), fromBits(z, bits)), normal40Levels(two));
}

// Stores a dielectric's f0 as a fraction of its f90, which it never exceeds in glTF: 8 bits of each channel in the
// lower word, the ninth bit of each in the upper. A gray f0 has 16 bits, and the last bit flags it.
SH_CONST uint kUntinted = 8u;
SH_FUNC uvec2 packReflectance(vec3 share) {
  if (share.x == share.y && share.y == share.z) return uvec2(rootBits(share.x, 16u), kUntinted);
  uint r = rootBits(share.x, 9u), g = rootBits(share.y, 9u), b = rootBits(share.z, 9u);
  return uvec2((r & 255u) | ((g & 255u) << 8u) | ((b & 255u) << 16u),
               (r >> 8u) | ((g >> 8u) << 1u) | ((b >> 8u) << 2u));
}
SH_FUNC vec3 unpackReflectance(uint low, uint high) {
  float gray = fromRootBits(low, 16u);
  if ((high & kUntinted) != 0u) return vec3(gray, gray, gray);
  return vec3(fromRootBits((low & 255u) | ((high & 1u) << 8u), 9u),
              fromRootBits(((low >> 8u) & 255u) | ((high & 2u) << 7u), 9u),
              fromRootBits(((low >> 16u) & 255u) | ((high & 4u) << 6u), 9u));
}

SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c) {
  GbufferTexel t;
  uvec2 normal = packNormal40(c.normalEncoding, toNormalSpace(c, kNormalSpaceWorld, s.normal));
  uvec2 reflectance = packReflectance(s.f0 * (s.f90 > 0.0f ? 1.0f / s.f90 : 0.0f));
  t.surface =
      uvec4(normal.x,
            normal.y | (rootBits(s.roughness, 12u) << 8u) | (packMetallic(s.metallic) << 20u) | (reflectance.y << 30u),
            rootBits(s.baseColor.x, 10u) | (rootBits(s.baseColor.y, 10u) << 10u) |
                (rootBits(s.baseColor.z, 10u) << 20u) | ((reflectance.y >> 2u) << 30u),
            reflectance.x | (rootBits(s.f90, 8u) << 24u));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  uvec4 v = t.surface;
  s.position = positionFromDepth(c);
  s.normal = fromNormalSpace(c, kNormalSpaceWorld, unpackNormal40(c.normalEncoding, v.x, v.y & 255u));
  s.roughness = fromRootBits(v.y >> 8u, 12u);
  s.metallic = unpackMetallic(v.y >> 20u);
  s.baseColor = vec3(fromRootBits(v.z, 10u), fromRootBits(v.z >> 10u, 10u), fromRootBits(v.z >> 20u, 10u));
  s.f90 = fromRootBits(v.w >> 24u, 8u);
  s.f0 = unpackReflectance(v.w & 0xffffffu, (v.y >> 30u) | ((v.z >> 30u) << 2u)) * s.f90;
  s.ao = c.ao;
  return s;
}

GBUFFER_END

#endif
