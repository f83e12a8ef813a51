// plain: the textbook G-buffer (the course "Game Programming with DirectX", slides on deferred shading): normal,
// diffuse albedo, specular albedo + power and position, all in floats. 68 bytes per pixel with depth.
//
// The alpha channels that the slides leave at 1 hold the other parameters of glTF's materials. Nothing that lighting
// needs is lost, and the image equals that of forward shading.
#ifndef LATELIGHT_SHARED_GBUFFER_PLAIN_H
#define LATELIGHT_SHARED_GBUFFER_PLAIN_H

#include "shared/diffuse_specular.h"
#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION "normal, diffuse, specular + power and position in floats; lossless"
#define GBUFFER_FIXED_NORMAL "three 32-bit floats"
#define GBUFFER_FIXED_POSITION "three 32-bit floats, world space"
#define GBUFFER_TARGETS(T)                                                                                          \
  T(0, normal, R32G32B32A32_SFLOAT, vec4, "xyz: world normal; w: ambient occlusion")                                \
  T(1, diffuse, R32G32B32A32_SFLOAT, vec4, "rgb: diffuse color; a: the dielectric's reflectance at grazing angles") \
  T(2, specular, R32G32B32A32_SFLOAT, vec4, "rgb: specular color; a: Blinn-Phong power")                            \
  T(3, position, R32G32B32A32_SFLOAT, vec4, "xyz: world position (m); w: metallic")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, SH_UNUSED GbufferContext c) {
  GbufferTexel t;
  vec3 diffuse = diffuseColor(s);
  vec3 specular = specularF0(s);
  t.normal = vec4(s.normal.x, s.normal.y, s.normal.z, s.ao);
  t.diffuse = vec4(diffuse.x, diffuse.y, diffuse.z, s.f90);
  t.specular = vec4(specular.x, specular.y, specular.z, powerFromRoughness(s.roughness));
  t.position = vec4(s.position.x, s.position.y, s.position.z, s.metallic);
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, SH_UNUSED GbufferContext c) {
  Surface s = emptySurface();
  s.position = vec3(t.position.x, t.position.y, t.position.z);
  s.normal = vec3(t.normal.x, t.normal.y, t.normal.z);
  s = withMetalness(s, vec3(t.diffuse.x, t.diffuse.y, t.diffuse.z), vec3(t.specular.x, t.specular.y, t.specular.z),
                    t.position.w);
  s.f90 = t.diffuse.w;
  s.roughness = roughnessFromExponent(t.specular.w);
  s.ao = t.normal.w;
  return s;
}

GBUFFER_END

#endif
