// Fog in closed form: a medium that attenuates a ray and adds its own color. Density falls exponentially with height or
// is uniform.
//
// Wenzel 2006, Real-time Atmospheric Effects in Games, SIGGRAPH course (the optical depth of exponential height fog
// along a ray); Quilez 2010, Better Fog, iquilezles.org. Extinction equals in-scattering: the fog is equally bright in
// all directions, so along a ray of transmittance T it adds color (1 - T).
#ifndef LATELIGHT_SHARED_FOG_H
#define LATELIGHT_SHARED_FOG_H

#include "shared/lang.h"

SH_BEGIN

struct Fog {      // all zero: none
  vec3 color;     // linear, after exposure: the color of infinitely deep fog
  float density;  // extinction at the height `base`, 1/m
  float falloff;  // density is multiplied by exp(-falloff (z - base)); 1/m, 0: uniform
  float base;     // world z, meters
};

// (1 - exp(-x)) / x, which is 1 at 0. Near 0, where the difference loses precision, its series is used.
SH_FUNC float meanExponential(float x) {
  if (abs(x) < 1e-2f) return 1.0f - x * (0.5f - x * (1.0f / 6.0f));
  return (1.0f - exp(-x)) / x;
}

// Fog of this optical depth is opaque, and larger exponents could overflow.
SH_CONST float kFogMaxExponent = 60.0f;

SH_FUNC float fogDensityAt(Fog fog, float z) {
  return fog.density * exp(min(-fog.falloff * (z - fog.base), kFogMaxExponent));
}

// Optical depth of `distance` meters from `origin` along the unit `direction` (world, Z up): the integral of the
// density. It starts at the lower end, where the density is largest, so no product overflows.
SH_FUNC float fogOpticalDepth(Fog fog, vec3 origin, vec3 direction, float distance) {
  float rise = direction.z * distance;
  return fogDensityAt(fog, origin.z + min(rise, 0.0f)) * distance * meanExponential(fog.falloff * abs(rise));
}

// Optical depth of an infinite ray; kFogMaxExponent if the ray never leaves the fog.
SH_FUNC float fogOpticalDepthToInfinity(Fog fog, vec3 origin, vec3 direction) {
  float thinning = fog.falloff * direction.z;  // rate at which the exponent falls along the ray, 1/m
  if (fog.density <= 0.0f) return 0.0f;
  if (thinning <= 0.0f) return kFogMaxExponent;
  return min(fogDensityAt(fog, origin.z) / thinning, kFogMaxExponent);
}

SH_FUNC float fogTransmittance(float opticalDepth) {
  return exp(-min(opticalDepth, kFogMaxExponent));
}

// Applies fog to radiance `c`, premultiplied by its alpha. The fog covers the background, so alpha grows.
SH_FUNC vec4 applyFog(Fog fog, vec4 c, float transmittance) {
  float added = 1.0f - transmittance;
  return vec4(c.x * transmittance + fog.color.x * added, c.y * transmittance + fog.color.y * added,
              c.z * transmittance + fog.color.z * added, c.w * transmittance + added);
}

SH_END

#endif
