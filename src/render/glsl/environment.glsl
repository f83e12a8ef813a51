// Environment light in shaders.
#include "render/glsl/lit_maps.glsl"
#include "shared/environment.h"
#include "shared/shade.h"

vec3 environmentRadiance(FrameConstants frame, vec3 direction, float roughness) {
  vec2 o = octahedralFromDirection(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  float level = roughness * (frame.environmentLevels - 1.0);
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
  vec3 reflected = reflect(-toEye, s.normal);
  vec3 specular = environmentRadiance(frame, reflected, s.roughness);
  vec2 o = octahedralFromDirection(rotateToEnvironment(s.normal, frame.environmentCos, frame.environmentSin));
  vec3 diffuse =
      textureLod(environmentDiffuse, octahedralTexture(o, float(textureSize(environmentDiffuse, 0).x)), 0.0).rgb;
  vec2 table = textureLod(reflectanceTable, vec2(nv, s.roughness), 0.0).rg;
  return shadeEnvironment(s, toEye, diffuse, specular, table) * frame.environmentIntensity;
}
