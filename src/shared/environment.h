// Image-based lighting (IBL): maps directions to texture coordinates of environment maps and back.
#ifndef LATELIGHT_SHARED_ENVIRONMENT_H
#define LATELIGHT_SHARED_ENVIRONMENT_H

#include "shared/lang.h"
#include "shared/normal/octahedral.h"

SH_BEGIN

// FrameConstants::environmentMap: the layer of the environment's maps in the low bits, then the level of the specular
// map that is the environment's level 0, then whether the specular and the diffuse map are among those of floats
// (kEnvironmentTwoTypes).
SH_CONST uint kEnvironmentLayerMask = 65535u;
SH_CONST uint kEnvironmentLevelShift = 16u, kEnvironmentLevelMask = 255u;
SH_CONST uint kEnvironmentFloatSpecular = 1u << 30u, kEnvironmentFloatDiffuse = 1u << 31u;

// The environments that a pass shades with, as the specialization constant kEnvironment.
SH_CONST uint kEnvironmentNone = 0u;
SH_CONST uint kEnvironmentOneType = 1u;   // all maps have the same type of texels
SH_CONST uint kEnvironmentTwoTypes = 2u;  // worlds have environments with halves and others with floats

// Rotates a world direction to the environment's own frame, about Z. At 0 degrees the image's center column is at +X;
// at 90 degrees it is at +Z of the glTF frame, which is -Y of the world.
SH_FUNC vec3 rotateToEnvironment(vec3 d, float cosine, float sine) {
  return vec3(cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z);
}

// Unit direction in which prefiltered maps are sampled for a rough lobe: the reflected ray, bent toward the normal.
// `lean` is the sine of its angle to the normal relative to that of the reflected ray: 1 is the reflected ray, 0 the
// normal.
SH_FUNC vec3 lobeDirection(vec3 normal, vec3 toEye, float lean) {
  vec3 along = (normal * dot(normal, toEye) - toEye) * lean;
  return along + normal * sqrt(max(1.0f - dot(along, along), 0.0f));
}

// Prefiltered level (scene::kSpecularRoughness) for one of many directions that share a lobe or the hemisphere, each
// with its solid angle (sr). It is the level nearest to the roughness whose lobe, of solid angle 4 pi alpha^2, is 0.3
// of the given solid angle. Twice that blurs, and less than half leaves gaps. The result is a single level instead of a
// blend of two, because neighboring directions use different levels.
SH_FUNC float levelOfShare(float solidAngle) {
  float a2 = solidAngle * (0.3f * 0.25f * kInvPi);
  float level = a2 < 6.25e-6f ? 0.0f : 1.0f;  // thresholds: fourth powers of the roughness between two levels
  level += a2 < 5.0625e-4f ? 0.0f : 1.0f;
  level += a2 < 4.569760e-3f ? 0.0f : 1.0f;
  level += a2 < 0.02825761f ? 0.0f : 1.0f;
  return level + (a2 < 0.3164062f ? 0.0f : 1.0f);
}

// Texture coordinate in the split-sum table, `size` texels wide, whose first and last texels are at 0 and 1.
SH_FUNC vec2 lobeTexture(float nv, float roughness, float size) {
  float scale = (size - 1.0f) / size;
  float first = 0.5f / size;
  return vec2(first + nv * scale, first + roughness * scale);
}

// Texture coordinate in [0, 1]^2 of an octahedral map `size` texels wide. Texel i is at o = 2 i / (size - 2) - 1. The
// axes and the square's edges, where the map is creased, are at texel centers, so bilinear filtering needs no texel
// beyond them (the last row and column are unused).
SH_FUNC vec2 octahedralTexture(vec2 o, float size) {
  float scale = (size - 2.0f) / size * 0.5f;
  float middle = (size - 1.0f) / size * 0.5f;
  return vec2(middle + o.x * scale, middle + o.y * scale);
}

// Texture coordinate of a direction in an equirectangular image: the center column is +X, u grows toward +Z of the glTF
// frame (-Y of the world), and the top row is the zenith. At the zenith itself, where GLSL's atan is undefined, u is
// that of the center.
SH_FUNC vec2 equirectangular(vec3 d) {
  float x = abs(d.x) + abs(d.y) > 0.0f ? d.x : 1.0f;
  return vec2(0.5f + atan2(-d.y, x) * (0.5f * kInvPi), acos(clamp(d.z, -1.0f, 1.0f)) * kInvPi);
}

SH_END

#endif
