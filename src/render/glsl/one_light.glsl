// Shading with one light, and the light counts for --debug lights.
#ifndef LATELIGHT_ONE_LIGHT_GLSL
#define LATELIGHT_ONE_LIGHT_GLSL
#include "render/glsl/setup.glsl"
#include "render/glsl/shadow.glsl"
#include "shared/shade.h"

#ifdef COATED  // define before the include: materials may have coats
#include "shared/layers.h"
#define LIT_BRDF LayeredBrdf
#define SHADE_LIGHT shadeLayeredLight
#else
#define LIT_BRDF SurfaceBrdf
#define SHADE_LIGHT shadeLight
#endif

// Number of lights tested for this pixel, and number of lights that contributed.
float lightsTested = 0.0;
float lightsUsed = 0.0;
vec4 lightCount() { return vec4(lightsTested, lightsUsed, 0.0, 0.0); }

// Returns the reflected radiance of one light, without shadows.
vec3 shadeUnshadowed(LightSample arriving, LIT_BRDF brdf) {
  vec3 radiance = SHADE_LIGHT(brdf, arriving, kShading);
  if (kCountLights != 0u && any(greaterThan(radiance, vec3(0.0)))) lightsUsed += 1.0;
  return radiance;
}

// Returns the reflected radiance of one light, with shadows.
vec3 shadeShadowed(FrameConstants frame, Light light, LightSample arriving, LightShadow shadow, Surface s, LIT_BRDF brdf) {
  vec3 radiance = SHADE_LIGHT(brdf, arriving, kShading);
#ifdef COATED
  if (dot(s.normal, arriving.toLight) < 0.0) s.normal = -s.normal;  // shadows are looked up on the light's side
#endif
  if (kShadowFormat != kShadowNone && shadow.maps != 0u && any(greaterThan(radiance, vec3(0.0))))
    radiance *= shadowFactor(frame, light, shadow, s, arriving.toLight);
  if (kCountLights != 0u && any(greaterThan(radiance, vec3(0.0)))) lightsUsed += 1.0;
  return radiance;
}

// Returns the radiance of one light that `s` reflects towards the eye, with shadows.
vec3 shadeOneLight(FrameConstants frame, Light light, LightShadow shadow, Surface s, LIT_BRDF brdf) {
  return shadeShadowed(frame, light, sampleLight(light, s.position), shadow, s, brdf);
}

// Returns the light's shadow maps, or none.
LightShadow shadowOf(FrameConstants frame, uint view, uint light) {
  if (kShadowFormat == kShadowNone) return LightShadow(0u, 0u, 0u);
  return lightShadow(frame, view, light);
}

#endif
