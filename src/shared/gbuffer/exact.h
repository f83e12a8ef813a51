// exact: every member of Surface in 32-bit floats. It is the source of the data outputs and, when lit, the reference
// for all other layouts. 116 bytes per pixel, including depth.
#ifndef LATELIGHT_SHARED_GBUFFER_EXACT_H
#define LATELIGHT_SHARED_GBUFFER_EXACT_H

#include "shared/gbuffer.h"

#define GBUFFER_KEEPS_FLAGS  // unlit and layered surfaces keep their values; lighting reads the flags
#define GBUFFER_DESCRIPTION "every value in 32-bit floats; the source of data outputs and the reference layout"
#define GBUFFER_FIXED_NORMAL "three 32-bit floats"
#define GBUFFER_FIXED_POSITION "three 32-bit floats, in the world"
#define GBUFFER_TARGETS(T)                                                                                 \
  T(0, position, R32G32B32A32_SFLOAT, vec4, "xyz: world position (m); w: ambient occlusion")               \
  T(1, normal, R32G32B32A32_SFLOAT, vec4, "xyz: world normal; w: roughness")                               \
  T(2, geonormal, R32G32B32A32_SFLOAT, vec4, "xyz: the triangle's world normal; w: metallic")              \
  T(3, albedo, R32G32B32A32_SFLOAT, vec4, "rgb: base color; a: reflectance at grazing angles")             \
  T(4, f0, R32G32B32A32_SFLOAT, vec4, "rgb: dielectric reflectance at normal incidence; a: u of UV set 0") \
  T(5, emissive, R32G32B32A32_SFLOAT, vec4, "rgb: emitted radiance; a: v of UV set 0")                     \
  T(6, ids, R32G32B32A32_UINT, uvec4, "r: id; g: id of the part; b: id of the material; a: 1 unlit, 2 layered")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, SH_UNUSED GbufferContext c) {
  GbufferTexel t;
  t.position = vec4(s.position.x, s.position.y, s.position.z, s.ao);
  t.normal = vec4(s.normal.x, s.normal.y, s.normal.z, s.roughness);
  t.geonormal = vec4(s.geonormal.x, s.geonormal.y, s.geonormal.z, s.metallic);
  t.albedo = vec4(s.baseColor.x, s.baseColor.y, s.baseColor.z, s.f90);
  t.f0 = vec4(s.f0.x, s.f0.y, s.f0.z, s.uv.x);
  t.emissive = vec4(s.emissive.x, s.emissive.y, s.emissive.z, s.uv.y);
  t.ids = uvec4(s.id, s.part, s.material, s.flags);
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, SH_UNUSED GbufferContext c) {
  Surface s = emptySurface();
  s.position = vec3(t.position.x, t.position.y, t.position.z);
  s.ao = t.position.w;
  s.normal = vec3(t.normal.x, t.normal.y, t.normal.z);
  s.roughness = t.normal.w;
  s.geonormal = vec3(t.geonormal.x, t.geonormal.y, t.geonormal.z);
  s.metallic = t.geonormal.w;
  s.baseColor = vec3(t.albedo.x, t.albedo.y, t.albedo.z);
  s.f90 = t.albedo.w;
  s.f0 = vec3(t.f0.x, t.f0.y, t.f0.z);
  s.emissive = vec3(t.emissive.x, t.emissive.y, t.emissive.z);
  s.uv = vec2(t.f0.w, t.emissive.w);
  s.id = t.ids.x;
  s.part = t.ids.y;
  s.material = t.ids.z;
  s.flags = t.ids.w;
  return s;
}

GBUFFER_END

#endif
