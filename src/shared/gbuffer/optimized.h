// optimized: the optimized textbook G-buffer (same course as plain.h): view-space normal in two channels, diffuse,
// specular and power, position from depth. 16 bytes per pixel with depth.
//
// Its limitations are kept: a specular power of eight bits, power / 255, which clamps Blinn-Phong powers above 255
// (perceptual roughness 0.30), and colors of eight bits (sRGB-encoded here).
#ifndef LATELIGHT_SHARED_GBUFFER_OPTIMIZED_H
#define LATELIGHT_SHARED_GBUFFER_OPTIMIZED_H

#include "shared/diffuse_specular.h"
#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION \
  "the optimized textbook G-buffer: encoded view-space normal, diffuse, specular + power, position from depth"
#define GBUFFER_TARGETS(T)                                                                           \
  T(0, normal, NORMAL32, vec4, "encoded view-space normal (two channels of 16 bits or three of 10)") \
  T(1, diffuse, R8G8B8A8_SRGB, vec4, "rgb: diffuse color; a: reflectance at grazing angles")         \
  T(2, specular, R8G8B8A8_SRGB, vec4, "rgb: specular color; a: Blinn-Phong power / 255")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c) {
  GbufferTexel t;
  t.normal = packNormal32(c, kNormalSpaceView, s.normal);
  vec3 diffuse = diffuseAtNormalIncidence(s);
  t.diffuse = vec4(diffuse.x, diffuse.y, diffuse.z, specularF90(s));
  vec3 f0 = specularF0(s);
  t.specular = vec4(f0.x, f0.y, f0.z, power8FromRoughness(s.roughness));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  s.normal = unpackNormal32(c, kNormalSpaceView, t.normal);
  s = withDiffuseSpecular(s, vec3(t.diffuse.x, t.diffuse.y, t.diffuse.z),
                          vec3(t.specular.x, t.specular.y, t.specular.z), t.diffuse.w);
  s.roughness = roughnessFromPower8(t.specular.w);
  s.ao = c.ao;
  return s;
}

GBUFFER_END

#endif
