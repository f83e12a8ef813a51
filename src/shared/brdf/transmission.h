// Transmission of light through a surface: KHR_materials_transmission, _volume and _dispersion. A thin wall transmits
// light without bending it, and its two rough sides blur it like a reflection along the view ray. A volume refracts the
// ray where it enters. A rasterizer does not know where the ray exits, so the background is sampled at the end of the
// refracted ray after `thickness`.
#ifndef LATELIGHT_SHARED_BRDF_TRANSMISSION_H
#define LATELIGHT_SHARED_BRDF_TRANSMISSION_H

#include "shared/brdf/ggx.h"

SH_BEGIN

// Absorption in 1/m per channel of a medium that attenuates white light to `color` after `distance` (m), by Beer's law.
// A distance that is not above 0 or is infinite absorbs nothing.
SH_FUNC float absorptionOf(float color, float distance) {
  if (distance <= 0.0f) return 0.0f;
  return max(log2(clamp(color, 1e-6f, 1.0f)) * (-0.69314718f / distance), 0.0f);
}
SH_FUNC vec3 absorptionOf(vec3 color, float distance) {
  return vec3(absorptionOf(color.x, distance), absorptionOf(color.y, distance), absorptionOf(color.z, distance));
}

// Fraction of light that remains after a path of that length (Beer's law).
SH_FUNC vec3 beersLaw(vec3 absorption, float path) {
  return vec3(exp(-absorption.x * path), exp(-absorption.y * path), exp(-absorption.z * path));
}

// Indices of refraction of red, green and blue. `dispersion` is 20 over the Abbe number.
SH_FUNC float dispersedIor(float ior, float dispersion, uint channel) {
  float spread = (ior - 1.0f) * 0.025f * dispersion;
  return max(ior + spread * (float(channel) - 1.0f), 1.0f);
}

// Direction (unit) of the ray from the eye after it has entered a medium (Snell's law). `nv` is n.v above 0, `ior` at
// least 1.
SH_FUNC vec3 refractedRay(vec3 normal, vec3 toEye, float nv, float ior) {
  float inverse = 1.0f / ior;
  float inside = sqrt(1.0f - (1.0f - nv * nv) * inverse * inverse);
  return normalize(normal * (nv * inverse - inside) - toEye * inverse);
}

// Perceptual roughness of the background as visible through a surface: the surface's roughness if the index of
// refraction is 1.5 or more, falling to 0 without refraction.
SH_FUNC float transmittedRoughness(float roughness, float ior) {
  return roughness * clamp(ior * 2.0f - 2.0f, 0.0f, 1.0f);
}

SH_END

#endif
