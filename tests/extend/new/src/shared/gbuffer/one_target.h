// one_target: a G-buffer layout with all inputs of lighting in one target of 16 bytes, including tinted reflectance and
// unlit surfaces. 20 bytes per pixel with depth.
#ifndef LATELIGHT_SHARED_GBUFFER_ONE_TARGET_H
#define LATELIGHT_SHARED_GBUFFER_ONE_TARGET_H

#include "shared/gbuffer.h"

#define GBUFFER_KEEPS_FLAGS
#define GBUFFER_DESCRIPTION "one target of 16 bytes: tinted reflectance and unlit surfaces stay"
#define GBUFFER_TARGETS(T)                                                                                            \
  T(0, surface, R32G32B32A32_UINT, uvec4,                                                                             \
    "r: world normal 24, roughness 8; g: base colour sRGB 24, metallic 8; b: reflectance sRGB 24, at grazing angles " \
    "8; "                                                                                                             \
    "a: ambient occlusion 16, flags 16")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c) {
  GbufferTexel t;
  uint normal = packNormal24(c.normalEncoding, toNormalSpace(c, kNormalSpaceWorld, s.normal));
  t.surface =
      uvec4(normal | (toBits(s.roughness, 8u) << 24u), packColor24(s.baseColor) | (toBits(s.metallic, 8u) << 24u),
            packColor24(s.f0) | (toBits(s.f90, 8u) << 24u), toBits(s.ao, 16u) | (s.flags << 16u));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  s.normal = fromNormalSpace(c, kNormalSpaceWorld, unpackNormal24(c.normalEncoding, t.surface.x & 0xffffffu));
  s.roughness = fromBits(t.surface.x >> 24u, 8u);
  s.baseColor = unpackColor24(t.surface.y & 0xffffffu);
  s.metallic = fromBits(t.surface.y >> 24u, 8u);
  s.f0 = unpackColor24(t.surface.z & 0xffffffu);
  s.f90 = fromBits(t.surface.z >> 24u, 8u);
  s.ao = fromBits(t.surface.w, 16u);
  s.flags = t.surface.w >> 16u;
  return s;
}

GBUFFER_END

#endif
