// battlefield3: the G-buffer of Battlefield 3 (J. Andersson, DirectX 11 Rendering in Battlefield 3, GDC 2011, DICE).
// Four targets of four bytes, 20 bytes per pixel with depth.
//
// Channels without a counterpart here are mapped: sky visibility is ambient occlusion; the environment id is 0, because
// a scene has one environment; the material parameter is metalness; and irradiance, which is baked light, holds emitted
// radiance (its successor kept both in that target: Lagarde and de Rousiers 2014, Moving Frostbite to Physically Based
// Rendering, section 4.5).
//
// Its limitations are kept: eight bits per component of the normal, and one gray dielectric reflectance. The material
// id marks matte and unlit surfaces.
#ifndef LATELIGHT_SHARED_GBUFFER_BATTLEFIELD3_H
#define LATELIGHT_SHARED_GBUFFER_BATTLEFIELD3_H

#include "shared/gbuffer.h"

#define GBUFFER_KEEPS_FLAGS  // stored as the material id
#define GBUFFER_DESCRIPTION \
  "Battlefield 3: normal + smoothness, diffuse + specular, sky visibility and material ids, irradiance"
#define GBUFFER_FIXED_NORMAL "world-space x, y and z, eight bits each"
#define GBUFFER_TARGETS(T)                                                                                             \
  T(0, normal, R8G8B8A8_UNORM, vec4, "rgb: world normal x, y, z * 0.5 + 0.5; a: smoothness, 1 - roughness")            \
  T(1, diffuse, R8G8B8A8_SRGB, vec4, "rgb: base color; a: square root of the dielectric's reflectance")                \
  T(2, material, R8G8B8A8_UNORM, vec4,                                                                                 \
    "r: sky visibility (ambient occlusion); g: environment id, 0; b: material parameter (metallic); a: material id / " \
    "255 (1 lit, 2 matte, 3 unlit)")                                                                                   \
  T(3, irradiance, R8G8B8A8_SRGB, vec4, "rgb: emitted radiance up to 1; a: unused")

GBUFFER_BEGIN

SH_CONST float kMaterialIdLit = 1.0f;
SH_CONST float kMaterialIdMatte = 2.0f;
SH_CONST float kMaterialIdUnlit = 3.0f;

SH_FUNC float materialId(Surface s) {
  if (s.flags != 0u) return kMaterialIdUnlit;  // also for layered surfaces, whose reflectance is never read
  return s.f90 <= 0.0f ? kMaterialIdMatte : kMaterialIdLit;
}

SH_FUNC GbufferTexel packGbuffer(Surface s, SH_UNUSED GbufferContext c) {
  GbufferTexel t;
  t.normal = vec4(s.normal.x * 0.5f + 0.5f, s.normal.y * 0.5f + 0.5f, s.normal.z * 0.5f + 0.5f, 1.0f - s.roughness);
  float f0 = (s.f0.x + s.f0.y + s.f0.z) * (1.0f / 3.0f);
  t.diffuse = vec4(s.baseColor.x, s.baseColor.y, s.baseColor.z, sqrt(max(f0, 0.0f)));
  t.material = vec4(s.ao, 0.0f, s.metallic, materialId(s) * (1.0f / 255.0f));
  t.irradiance = vec4(min(s.emissive.x, 1.0f), min(s.emissive.y, 1.0f), min(s.emissive.z, 1.0f), 0.0f);
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  s.normal = normalize(vec3(t.normal.x * 2.0f - 1.0f, t.normal.y * 2.0f - 1.0f, t.normal.z * 2.0f - 1.0f));
  s.roughness = 1.0f - t.normal.w;
  s.baseColor = vec3(t.diffuse.x, t.diffuse.y, t.diffuse.z);
  float f0 = t.diffuse.w * t.diffuse.w;
  s.f0 = vec3(f0, f0, f0);
  s.ao = t.material.x;
  s.metallic = t.material.z;
  float id = floor(t.material.w * 255.0f + 0.5f);
  s.f90 = id == kMaterialIdMatte ? 0.0f : 1.0f;
  s.flags = id == kMaterialIdUnlit ? kSurfaceUnlit : 0u;
  s.emissive = vec3(t.irradiance.x, t.irradiance.y, t.irradiance.z);
  return s;
}

GBUFFER_END

#endif
