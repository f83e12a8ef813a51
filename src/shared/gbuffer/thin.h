// thin: all parameters of GGX in 12 bytes per pixel, including depth. It requires the least memory, with an error of a
// few 8-bit levels.
#ifndef LATELIGHT_SHARED_GBUFFER_THIN_H
#define LATELIGHT_SHARED_GBUFFER_THIN_H

#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION "all GGX parameters in 12 bytes per pixel with depth; accurate to a few 8-bit levels"
#define GBUFFER_TARGETS(T)          \
  T(0, surface, R32G32_UINT, uvec2, \
    "r: world normal 24 (12+12 or 8+8+8), roughness 8; g: base color sRGB 8+8+8, metallic 5, reflectance 3")

GBUFFER_BEGIN

// Stores a dielectric's f0 in 3 bits: f0 = 0.16 r^2 (Lagarde and de Rousiers 2014, section 3.1.3) with r = code / 6, so
// code 3 is the usual 0.04, and code 0 reflects nothing at any angle. A tinted f0 is replaced by its mean.
SH_FUNC uint packReflectance(vec3 f0, float f90) {
  if (f90 <= 0.0f) return 0u;
  float r = sqrt(max((f0.x + f0.y + f0.z) * (1.0f / 3.0f), 0.0f) / 0.16f);
  return min(uint(r * 6.0f + 0.5f), 7u);
}

SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c) {
  GbufferTexel t;
  uint normal = packNormal24(c.normalEncoding, toNormalSpace(c, kNormalSpaceWorld, s.normal));
  t.surface = uvec2(normal | (toBits(s.roughness, 8u) << 24u),
                    packColor24(s.baseColor) | (toBits(s.metallic, 5u) << 24u) | (packReflectance(s.f0, s.f90) << 29u));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  s.normal = fromNormalSpace(c, kNormalSpaceWorld, unpackNormal24(c.normalEncoding, t.surface.x & 0xffffffu));
  s.roughness = fromBits(t.surface.x >> 24u, 8u);
  s.baseColor = unpackColor24(t.surface.y & 0xffffffu);
  s.metallic = fromBits(t.surface.y >> 24u, 5u);
  float code = float(t.surface.y >> 29u);
  float f0 = 0.16f / 36.0f * code * code;
  s.f0 = vec3(f0, f0, f0);
  s.f90 = code > 0.0f ? 1.0f : 0.0f;
  s.ao = c.ao;
  return s;
}

GBUFFER_END

#endif
