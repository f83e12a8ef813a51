// Light through a surface: KHR_materials_transmission, _volume and _dispersion. A thin wall lets light through
// straight, and its two rough sides blur it like a reflection seen along the ray. A volume bends the ray where it
// enters; where it leaves is not known to a rasterizer, so that what is seen through it lies where the bent ray ends
// after `thickness`.
#ifndef LATELIGHT_SHARED_BRDF_TRANSMISSION_H
#define LATELIGHT_SHARED_BRDF_TRANSMISSION_H

#include "shared/brdf/ggx.h"

SH_BEGIN

// 1/m for each channel of a medium that leaves `color` of white light after `distance` (m), by Beer's law. A distance
// that is not above 0 or is infinite absorbs nothing.
SH_FUNC float absorptionOf(float color, float distance) {
  if (distance <= 0.0f) return 0.0f;
  return max(log2(clamp(color, 1e-6f, 1.0f)) * (-0.69314718f / distance), 0.0f);
}
SH_FUNC vec3 absorptionOf(vec3 color, float distance) {
  return vec3(absorptionOf(color.x, distance), absorptionOf(color.y, distance), absorptionOf(color.z, distance));
}

// Share of light that is left after a path of that length.
SH_FUNC vec3 beersLaw(vec3 absorption, float path) {
  return vec3(exp(-absorption.x * path), exp(-absorption.y * path), exp(-absorption.z * path));
}

// Indices of refraction of red, green and blue. `dispersion` is 20 over the Abbe number.
SH_FUNC float dispersedIor(float ior, float dispersion, uint channel) {
  float spread = (ior - 1.0f) * 0.025f * dispersion;
  return max(ior + spread * (float(channel) - 1.0f), 1.0f);
}

// The direction of the ray from the eye once it has entered a medium (unit). `nv` is n.v above 0, `ior` at least 1.
SH_FUNC vec3 refractedRay(vec3 normal, vec3 toEye, float nv, float ior) {
  float inverse = 1.0f / ior;
  float inside = sqrt(1.0f - (1.0f - nv * nv) * inverse * inverse);
  return normalize(normal * (nv * inverse - inside) - toEye * inverse);
}

// Perceptual roughness of what is seen through a surface: that of the surface where the index of refraction is 1.5 or
// more, and none without refraction.
SH_FUNC float transmittedRoughness(float roughness, float ior) {
  return roughness * clamp(ior * 2.0f - 2.0f, 0.0f, 1.0f);
}

SH_END

#endif
