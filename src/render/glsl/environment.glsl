// Image-based lighting (IBL): environment light from prefiltered maps and the split-sum approximation.
#ifndef LATELIGHT_ENVIRONMENT_GLSL
#define LATELIGHT_ENVIRONMENT_GLSL
#include "render/glsl/lit_maps.glsl"
#include "shared/environment.h"
#include "shared/shade.h"

// Returns the scale of f0 and of f90 for the specular lobe.
vec2 splitSum(Surface s, vec3 toEye) {
  return textureLod(reflectanceTable, vec2(clamp(dot(s.normal, toEye), 0.0, 1.0), s.roughness), 0.0).rg;
}

// Call it before lights: sets the energy-compensated diffuse reflectance if the shading model compensates energy.
void prepareForLights(inout Surface s, vec3 toEye) {
  if (kShading == kShadingGgxCompensated) s.scattered = surfaceReflectance(s, splitSum(s, toEye)).scattered;
}

vec2 environmentOctahedral(FrameConstants frame, vec3 direction) {
  return octahedralFromDirection(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
}

// The environment's layer in the maps, and the level of the specular maps that is its level 0. Both are 0 except in
// views of worlds that choose their environments.
struct EnvironmentPlace {
  float layer, level;
};
EnvironmentPlace environmentPlace(FrameConstants frame) {
  return EnvironmentPlace(float(frame.environmentMap & kEnvironmentLayerMask),
                          float(frame.environmentMap >> kEnvironmentLevelShift & kEnvironmentLevelMask));
}

// Halves are not converted to floats for worlds with environments of both types, because GPUs filter floats with other
// rounding.
bool hasFloats(FrameConstants frame, uint map) {
  return kEnvironment == kEnvironmentTwoTypes && (frame.environmentMap & map) != 0u;
}

vec3 specularTexel(FrameConstants frame, vec2 octahedral, EnvironmentPlace place, int size, float level) {
  vec3 at = vec3(octahedralTexture(octahedral, float(size)), place.layer);
  vec3 texel = textureLod(environmentSpecular, at, level).rgb;
  if (hasFloats(frame, kEnvironmentFloatSpecular)) texel = textureLod(environmentSpecularFloats, at, level).rgb;
  return texel;
}

// Returns prefiltered radiance, interpolated between two levels.
vec3 environmentRadiance(FrameConstants frame, vec3 direction, float level) {
  vec2 o = environmentOctahedral(frame, direction);
  EnvironmentPlace place = environmentPlace(frame);
  float lower = min(floor(level), frame.environmentLevels - 2.0), stored = lower + place.level;
  // Each level has its own border, so trilinear filtering needs two bilinear fetches with different coordinates. Their
  // sizes follow from level 0, because lavapipe returns textureSize of the first lane's level for all lanes.
  int size = textureSize(environmentSpecular, 0).x >> int(stored);
  vec3 a = specularTexel(frame, o, place, size, stored);
  vec3 b = specularTexel(frame, o, place, size >> 1, stored + 1.0);
  return mix(a, b, level - lower);
}

// Returns prefiltered radiance of one level.
vec3 environmentLevel(FrameConstants frame, vec3 direction, float level) {
  EnvironmentPlace place = environmentPlace(frame);
  float stored = level + place.level;
  int size = textureSize(environmentSpecular, 0).x >> int(stored);
  return specularTexel(frame, environmentOctahedral(frame, direction), place, size, stored);
}

// Returns irradiance / pi around a normal.
vec3 environmentDiffuseAt(FrameConstants frame, vec3 normal) {
  vec2 o = environmentOctahedral(frame, normal);
  vec3 at = vec3(octahedralTexture(o, float(textureSize(environmentDiffuse, 0).x)), environmentPlace(frame).layer);
  vec3 texel = textureLod(environmentDiffuse, at, 0.0).rgb;
  if (hasFloats(frame, kEnvironmentFloatDiffuse)) texel = textureLod(environmentDiffuseFloats, at, 0.0).rgb;
  return texel;
}

// Returns the mean radiance over a reflected lobe. `diffuse` is environmentDiffuseAt() of the normal.
vec3 environmentLobe(FrameConstants frame, vec3 normal, vec3 toEye, float roughness, vec3 diffuse) {
  float nv = clamp(dot(normal, toEye), 0.0, 1.0);
  vec3 lobe = textureLod(lobeTable, lobeTexture(nv, roughness, float(textureSize(lobeTable, 0).x)), 0.0).rgb;
  vec3 specular = environmentRadiance(frame, lobeDirection(normal, toEye, lobe.x), lobe.y);
  return mix(specular, diffuse, lobe.z);
}

// A specialization constant comes first, because lavapipe executes both sides of a branch.
bool hasEnvironment(FrameConstants frame) {
  return kEnvironment != kEnvironmentNone && frame.environmentIntensity != 0.0;
}

vec3 environmentLight(FrameConstants frame, Surface s, vec3 toEye) {
  if (!hasEnvironment(frame)) return vec3(0.0);
  vec3 diffuse = environmentDiffuseAt(frame, s.normal);
  vec3 specular = environmentLobe(frame, s.normal, toEye, s.roughness, diffuse);
  return shadeEnvironment(s, toEye, diffuse, specular, splitSum(s, toEye)) * frame.environmentIntensity;
}

#endif
