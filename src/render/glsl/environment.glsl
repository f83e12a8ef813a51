// Environment light in shaders.
#include "render/glsl/lit_maps.glsl"
#include "shared/environment.h"
#include "shared/shade.h"

// Scale and bias of f0 and f90 of the surface's lobe.
vec2 splitSum(Surface s, vec3 toEye) {
  return textureLod(reflectanceTable, vec2(clamp(dot(s.normal, toEye), 0.0, 1.0), s.roughness), 0.0).rg;
}

// Before lights: what the surface scatters, where the shading compensates energy.
void prepareForLights(inout Surface s, vec3 toEye) {
  if (kShading == kShadingGgxCompensated) s.scattered = surfaceReflectance(s, splitSum(s, toEye)).scattered;
}

vec2 environmentOctahedral(FrameConstants frame, vec3 direction) {
  return octahedralFromDirection(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
}

// Of the prefiltered levels; between two of them a mixture.
vec3 environmentRadiance(FrameConstants frame, vec3 direction, float level) {
  vec2 o = environmentOctahedral(frame, direction);
  float lower = min(floor(level), frame.environmentLevels - 2.0);
  // Each level has its own border, so trilinear filtering is two bilinear fetches at coordinates of their own.
  // Sizes follow from level 0's: lavapipe 22.3 answers textureSize for all lanes with the first lane's level.
  int size = textureSize(environmentSpecular, 0).x >> int(lower);
  vec3 a = textureLod(environmentSpecular, octahedralTexture(o, float(size)), lower).rgb;
  vec3 b = textureLod(environmentSpecular, octahedralTexture(o, float(size >> 1)), lower + 1.0).rgb;
  return mix(a, b, level - lower);
}

vec3 environmentLight(FrameConstants frame, Surface s, vec3 toEye) {
  if (frame.environmentIntensity == 0.0) return vec3(0.0);
  float nv = clamp(dot(s.normal, toEye), 0.0, 1.0);
  vec2 o = environmentOctahedral(frame, s.normal);
  vec3 diffuse =
      textureLod(environmentDiffuse, octahedralTexture(o, float(textureSize(environmentDiffuse, 0).x)), 0.0).rgb;
  vec3 lobe = textureLod(lobeTable, lobeTexture(nv, s.roughness, float(textureSize(lobeTable, 0).x)), 0.0).rgb;
  vec3 specular = environmentRadiance(frame, lobeDirection(s.normal, toEye, lobe.x), lobe.y);
  specular = mix(specular, diffuse, lobe.z);
  return shadeEnvironment(s, toEye, diffuse, specular, splitSum(s, toEye)) * frame.environmentIntensity;
}
