// killzone2: the G-buffer of Killzone 2 (M. Valient, Deferred Rendering in Killzone 2, Develop 2007, Guerrilla Games).
// 20 bytes per pixel in the original: light accumulation + intensity, three targets of four bytes, depth and stencil.
//
// Its limitations are kept. The normal lacks the sign of its view depth, so normals that face away from the view plane
// (at the edge of a wide view, or because of a normal map) come back mirrored. For nearly perpendicular normals, the
// eleven bits of x and z leave an error of about a degree. The specular power has eight bits. There is one color and a
// specular intensity: a colored highlight has the color of the albedo as far as its intensity exceeds that of a usual
// dielectric. Motion is precise to an eighth of a pixel and clamped to 32 pixels per frame on each axis.
#ifndef LATELIGHT_SHARED_GBUFFER_KILLZONE2_H
#define LATELIGHT_SHARED_GBUFFER_KILLZONE2_H

#include "shared/diffuse_specular.h"
#include "shared/gbuffer.h"

#define GBUFFER_DESCRIPTION \
  "Killzone 2: normal.xy in halves, motion, specular power and intensity, albedo, sun occlusion"
#define GBUFFER_FIXED_NORMAL "two half floats, across and up in view space"
#define GBUFFER_KEEPS_MOTION
#define GBUFFER_DEPTH_FORMAT D24_UNORM_S8_UINT
#define GBUFFER_LIGHT_FORMAT R8G8B8A8_UNORM
#define GBUFFER_SUN_TARGET 2
#define GBUFFER_TARGETS(T)                                                                                         \
  T(0, normal, R16G16_SFLOAT, vec4, "rg: view-space normal, right and up; the third component is reconstructed")   \
  T(1, motion, R8G8B8A8_UNORM, vec4,                                                                               \
    "rg: motion to the previous frame in quarter pixels, 128 is 0; b: Blinn-Phong power / 255; a: square root of " \
    "specular intensity")                                                                                          \
  T(2, albedo, R8G8B8A8_SRGB, vec4, "rgb: base color; a: sun occlusion, 1 where the sun shines")

GBUFFER_BEGIN

// The maximum intensity of a dielectric surface; its square root is exactly an 8-bit code, 51.
SH_CONST float kDielectricIntensity = 0.04f;

// The metalness that makes specularF0()'s largest channel `intensity`.
SH_FUNC float metallicFromIntensity(float intensity, float largestBase) {
  float range = largestBase - kDielectricIntensity;
  return range > 1e-3f ? saturate((intensity - kDielectricIntensity) / range) : 0.0f;
}

// Motion in pixels as eight bits per channel, and back. Code 128 is no motion.
SH_CONST float kMotionSteps = 4.0f;  // steps per pixel
SH_FUNC float motionCode(float pixels) {
  return clamp(floor(pixels * kMotionSteps + 128.5f), 0.0f, 255.0f) / 255.0f;
}
SH_FUNC float motionFromCode(float code) {
  return (floor(code * 255.0f + 0.5f) - 128.0f) / kMotionSteps;
}

SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c) {
  GbufferTexel t;
  vec3 n = rotateToView(c.view, s.normal);
  t.normal = vec4(n.x, n.z, 0.0f, 0.0f);
  t.motion = vec4(motionCode(s.motion.x), motionCode(s.motion.y), power8FromRoughness(s.roughness),
                  sqrt(max(maxChannel(specularF0(s)), 0.0f)));
  t.albedo = vec4(s.baseColor.x, s.baseColor.y, s.baseColor.z, s.sun);
  return t;
}

SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c) {
  Surface s = emptySurface();
  s.position = positionFromDepth(c);
  float away = -sqrt(saturate(1.0f - t.normal.x * t.normal.x - t.normal.y * t.normal.y));
  s.normal = rotateToWorld(c.view, normalize(vec3(t.normal.x, away, t.normal.y)));
  s.baseColor = vec3(t.albedo.x, t.albedo.y, t.albedo.z);
  float intensity = t.motion.w * t.motion.w;
  s.metallic = metallicFromIntensity(intensity, maxChannel(s.baseColor));
  float f0 = s.metallic > 0.0f ? kDielectricIntensity : intensity;
  s.f0 = vec3(f0, f0, f0);
  s.f90 = intensity > 0.0f ? 1.0f : 0.0f;
  s.roughness = roughnessFromPower8(t.motion.z);
  s.motion = vec2(motionFromCode(t.motion.x), motionFromCode(t.motion.y));
  s.ao = c.ao;
  s.sun = t.albedo.w;
  return s;
}

GBUFFER_END

#endif
