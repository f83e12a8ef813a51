// One light at a surface, and the counts of lights that --debug lights shows.
#ifndef LATELIGHT_ONE_LIGHT_GLSL
#define LATELIGHT_ONE_LIGHT_GLSL
#include "render/glsl/setup.glsl"
#include "render/glsl/shadow.glsl"
#include "shared/shade.h"

// How many lights this pixel went through, and how many of them sent it anything.
float lightsTested = 0.0;
float lightsUsed = 0.0;
vec4 lightCount() { return vec4(lightsTested, lightsUsed, 0.0, 0.0); }

// Radiance that one light sends from `s` to the eye, as if nothing stood between them.
vec3 shadeUnshadowed(Light light, Surface s, SurfaceBrdf brdf) {
  vec3 radiance = shadeLight(brdf, sampleLight(light, s.position), kShading);
  if (kCountLights != 0u && any(greaterThan(radiance, vec3(0.0)))) lightsUsed += 1.0;
  return radiance;
}

// Radiance that one light sends from `s` to the eye.
vec3 shadeOneLight(FrameConstants frame, Light light, LightShadow shadow, Surface s, SurfaceBrdf brdf) {
  LightSample arriving = sampleLight(light, s.position);
  vec3 radiance = shadeLight(brdf, arriving, kShading);
  if (kShadowFormat != kShadowNone && shadow.maps != 0u && any(greaterThan(radiance, vec3(0.0))))
    radiance *= shadowFactor(frame, light, shadow, s, arriving.toLight);
  if (kCountLights != 0u && any(greaterThan(radiance, vec3(0.0)))) lightsUsed += 1.0;
  return radiance;
}


// Its shadow maps, where the frame has any.
LightShadow shadowOf(FrameConstants frame, uint view, uint light) {
  if (kShadowFormat == kShadowNone) return LightShadow(0u, 0u, 0u);
  return lightShadow(frame, view, light);
}

#endif
