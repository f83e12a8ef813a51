// blog: the G-buffer of a Direct3D 11 blog post ("Deferred Rendering", in Korean): lit color, UUID, world position,
// octahedral normal in R16G16, albedo, specular + exponent. 60 bytes per pixel with depth.
//
// The lit color corresponds to the light accumulation target of every frame here, but in 32-bit floats. Colors and
// positions are floats, as in the post; only normals are quantized.
#ifndef LATELIGHT_SHARED_GBUFFER_BLOG_H
#define LATELIGHT_SHARED_GBUFFER_BLOG_H

#include "shared/diffuse_specular.h"
#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION \
  "lit color, UUID for picking, world position, octahedral normal, albedo, specular + exponent"
#define GBUFFER_FIXED_NORMAL "octahedral in two channels of 16 bits"
#define GBUFFER_FIXED_POSITION "three 32-bit floats, world space"
#define GBUFFER_LIGHT_FORMAT R32G32B32A32_SFLOAT
#define GBUFFER_TARGETS(T)                                                        \
  T(0, uuid, R32_UINT, uint, "r: id of the object")                               \
  T(1, position, R32G32B32A32_SFLOAT, vec4,                                       \
    "xyz: world position (m); w: the dielectric's reflectance at grazing angles") \
  T(2, normal, R16G16_UNORM, vec4, "rg: world normal, octahedral")                \
  T(3, albedo, R32G32B32A32_SFLOAT, vec4, "rgb: diffuse color; a: metallic")      \
  T(4, specular, R32G32B32A32_SFLOAT, vec4, "rgb: specular color; a: Blinn-Phong exponent")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, SH_UNUSED GbufferContext c) {
  GbufferTexel t;
  vec3 diffuse = diffuseColor(s);
  vec3 specular = specularF0(s);
  vec2 o = octahedralFromDirection(s.normal);
  t.uuid = s.id;
  t.position = vec4(s.position.x, s.position.y, s.position.z, s.f90);
  t.normal = vec4(o.x * 0.5f + 0.5f, o.y * 0.5f + 0.5f, 0.0f, 0.0f);
  t.albedo = vec4(diffuse.x, diffuse.y, diffuse.z, s.metallic);
  t.specular = vec4(specular.x, specular.y, specular.z, powerFromRoughness(s.roughness));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.id = t.uuid;
  s.position = vec3(t.position.x, t.position.y, t.position.z);
  s.normal = directionFromOctahedral(vec2(t.normal.x * 2.0f - 1.0f, t.normal.y * 2.0f - 1.0f));
  s = withMetalness(s, vec3(t.albedo.x, t.albedo.y, t.albedo.z), vec3(t.specular.x, t.specular.y, t.specular.z),
                    t.albedo.w);
  s.f90 = t.position.w;
  s.roughness = roughnessFromExponent(t.specular.w);
  s.ao = c.ao;
  return s;
}

GBUFFER_END

#endif
