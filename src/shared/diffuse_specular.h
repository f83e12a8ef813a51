// Diffuse and specular colors in place of base color and metalness, for G-buffer layouts that predate metalness.
#ifndef LATELIGHT_SHARED_DIFFUSE_SPECULAR_H
#define LATELIGHT_SHARED_DIFFUSE_SPECULAR_H

#include "shared/brdf/blinn_phong.h"
#include "shared/color.h"
#include "shared/lang.h"
#include "shared/surface.h"

SH_BEGIN

// The diffuse color to store: diffuse reflectance at normal incidence. glTF's diffuse part is diffuseColor (1 - F),
// where F is the Fresnel term of only the dielectric. A surface described by its mixed specular color instead has the
// larger F of the mix, so a partly metallic surface would become too dark. For a grazing reflectance of 1, both have 1
// - F = (1 - f0)(1 - w) with Schlick's weight w. The stored value is therefore the color times (1 - f0), and
// withDiffuseSpecular() divides by the other factor. The result is exact for punctual lights, and nearly exact for
// environments, whose F is not quite linear in f0.
SH_FUNC vec3 diffuseAtNormalIncidence(Surface s) {
  return diffuseColor(s) * (1.0f - maxChannel(s.f0));
}

// Returns the surface without metalness that shades like the one from which diffuseAtNormalIncidence(), specularF0()
// and specularF90() were computed.
SH_FUNC Surface withDiffuseSpecular(Surface s, vec3 diffuse, vec3 specular, float f90) {
  float left = 1.0f - maxChannel(specular);
  float scale = left > 0.0f ? 1.0f / left : 0.0f;
  s.baseColor = vec3(saturate(diffuse.x * scale), saturate(diffuse.y * scale), saturate(diffuse.z * scale));
  s.metallic = 0.0f;
  s.f0 = specular;
  s.f90 = f90;
  return s;
}

// Recovers base color and dielectric reflectance from diffuseColor(), specularF0() and metalness, all in floats,
// without loss. Near metalness 1 the dielectric's reflectance is divided by nearly 0, but its weight is equally small.
SH_FUNC Surface withMetalness(Surface s, vec3 diffuse, vec3 specular, float metallic) {
  float rest = 1.0f - metallic;
  s.metallic = metallic;
  s.baseColor = specular;
  s.f0 = vec3(0.0f, 0.0f, 0.0f);
  if (rest > 1e-6f) {
    s.baseColor = diffuse * (1.0f / rest);
    vec3 f0 = (specular - s.baseColor * metallic) * (1.0f / rest);
    s.f0 = vec3(saturate(f0.x), saturate(f0.y), saturate(f0.z));
  }
  return s;
}

// A Blinn-Phong power in eight bits, power / 255. Powers above 255 (perceptual roughness 0.30) are clamped.
SH_FUNC float power8FromRoughness(float roughness) {
  return saturate(exponentFromRoughness(roughness) * (1.0f / 255.0f));
}
SH_FUNC float roughnessFromPower8(float stored) {
  return roughnessFromExponent(stored * 255.0f);
}

// A power as a float, without the lower limit on roughness that shading imposes: environments are looked up by the
// roughness itself. Roughness 0 becomes 1e-6.
SH_FUNC float powerFromRoughness(float roughness) {
  float r = max(roughness, 1e-6f);
  return 2.0f / (r * r * r * r) - 2.0f;
}

SH_END

#endif
