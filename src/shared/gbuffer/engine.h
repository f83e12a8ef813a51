// engine: the G-buffer described in the shader notes of a small Direct3D 11 engine: normal, diffuse + ambient
// occlusion, specular + power. 16 bytes per pixel with depth.
//
// The notes name channels but no formats. Here normals have ten bits per component, in a format whose fourth channel is
// unused, as in the notes, and colors have eight (sRGB-encoded). Reflectance at grazing angles is not stored: it is 1
// if the specular color is not black.
#ifndef LATELIGHT_SHARED_GBUFFER_ENGINE_H
#define LATELIGHT_SHARED_GBUFFER_ENGINE_H

#include "shared/diffuse_specular.h"
#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION "a small engine: normal.xyz, diffuse + ambient occlusion, specular + power"
#define GBUFFER_FIXED_NORMAL "world-space x, y and z, ten bits each"
#define GBUFFER_TARGETS(T)                                                                         \
  T(0, normal, A2B10G10R10_UNORM_PACK32, vec4, "rgb: world normal x, y, z * 0.5 + 0.5; a: unused") \
  T(1, diffuse, R8G8B8A8_SRGB, vec4, "rgb: diffuse color; a: ambient occlusion")                   \
  T(2, specular, R8G8B8A8_SRGB, vec4, "rgb: specular color; a: Blinn-Phong power / 255")

GBUFFER_BEGIN

SH_FUNC GbufferTexel packGbuffer(Surface s, SH_UNUSED GbufferContext c) {
  GbufferTexel t;
  vec3 diffuse = diffuseAtNormalIncidence(s);
  vec3 specular = specularF0(s);
  t.normal = vec4(s.normal.x * 0.5f + 0.5f, s.normal.y * 0.5f + 0.5f, s.normal.z * 0.5f + 0.5f, 0.0f);
  t.diffuse = vec4(diffuse.x, diffuse.y, diffuse.z, s.ao);
  t.specular = vec4(specular.x, specular.y, specular.z, power8FromRoughness(s.roughness));
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  s.normal = normalize(vec3(t.normal.x * 2.0f - 1.0f, t.normal.y * 2.0f - 1.0f, t.normal.z * 2.0f - 1.0f));
  vec3 specular = vec3(t.specular.x, t.specular.y, t.specular.z);
  s = withDiffuseSpecular(s, vec3(t.diffuse.x, t.diffuse.y, t.diffuse.z), specular,
                          maxChannel(specular) > 0.0f ? 1.0f : 0.0f);
  s.roughness = roughnessFromPower8(t.specular.w);
  s.ao = t.diffuse.w;
  return s;
}

GBUFFER_END

#endif
