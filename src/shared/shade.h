// shade(): from a Surface and a light to outgoing radiance. Every lighting technique calls these and nothing else.
#ifndef LATELIGHT_SHARED_SHADE_H
#define LATELIGHT_SHARED_SHADE_H

#include "shared/brdf/blinn_phong.h"
#include "shared/brdf/ggx.h"
#include "shared/color.h"
#include "shared/light.h"
#include "shared/surface.h"

SH_BEGIN

SH_CONST uint kShadingGgx = 0u;
SH_CONST uint kShadingBlinnPhong = 1u;

// Least n.v: interpolated and mapped normals may point away from the eye that sees the surface.
SH_CONST float kMinNv = 1e-4f;

// glTF 2.0, appendix B: mix(dielectric, metal, metallic), both over one specular lobe; the dielectric's diffuse part
// gets what its Fresnel term leaves, by the largest channel (KHR_materials_specular). 1/sr.
SH_FUNC vec3 ggxBrdf(Surface s, float nl, float nv, float nh, float sin2, float vh) {
  float alpha = ggxAlpha(s.roughness);
  float lobe = ggxDistribution(nh, sin2, alpha) * ggxVisibility(nl, nv, alpha);
  vec3 dielectric = schlick(s.f0, s.f90, vh);
  vec3 metal = schlick(s.baseColor, 1.0f, vh);
  vec3 fresnel = dielectric + (metal - dielectric) * s.metallic;
  return diffuseColor(s) * ((1.0f - maxChannel(dielectric)) * kInvPi) + fresnel * lobe;
}

// The seeds' diffuse and specular colours under one normalised lobe, without Fresnel; the dielectric's diffuse part
// gets what its specular colour leaves, so that no surface reflects more than it receives at normal incidence. 1/sr.
SH_FUNC vec3 blinnPhongBrdf(Surface s, float nh, float sin2) {
  return diffuseColor(s) * ((1.0f - maxChannel(s.f0)) * kInvPi) +
         specularF0(s) * blinnPhong(nh, sin2, exponentFromRoughness(s.roughness));
}

// Radiance leaving `s` towards the eye by one light, single scattering. `toEye` is unit, world space.
SH_FUNC vec3 shadeLight(Surface s, vec3 toEye, LightSample light, uint shading) {
  float nl = dot(s.normal, light.toLight);
  if (nl <= 0.0f) return vec3(0.0f, 0.0f, 0.0f);
  nl = min(nl, 1.0f);
  vec3 sum = light.toLight + toEye;
  float squared = dot(sum, sum);
  vec3 h =
      sum * (squared > 1e-12f ? inversesqrt(squared) : 0.0f);  // light from behind the eye's far side: no highlight
  vec3 across = cross(s.normal, h);
  float sin2 = dot(across, across);
  float nh = saturate(dot(s.normal, h));
  vec3 brdf;
  if (shading == kShadingBlinnPhong) {
    brdf = blinnPhongBrdf(s, nh, sin2);
  } else {
    float nv = clamp(dot(s.normal, toEye), kMinNv, 1.0f);
    brdf = ggxBrdf(s, nl, nv, nh, sin2, saturate(dot(toEye, h)));
  }
  return brdf * light.irradiance * nl;
}

// Reflection of an environment by a microfacet surface of reflectance f0 to f90: what is reflected once, and what
// leaves after several reflections between facets (Fdez-Aguera 2019, A Multiple-Scattering Microfacet Model for
// Real-Time Image Based Lighting, JCGT 8(1)).
struct EnvironmentReflectance {
  vec3 once;
  vec3 more;
};
SH_FUNC EnvironmentReflectance environmentReflectance(vec3 f0, float f90, vec2 table) {
  EnvironmentReflectance r;
  r.once = f0 * table.x + vec3(f90, f90, f90) * table.y;
  // Cosine-weighted mean of Schlick's term over the hemisphere: f0 + (f90 - f0) / 21.
  vec3 mean = f0 + (vec3(f90, f90, f90) - f0) * (1.0f / 21.0f);
  float lost = saturate(1.0f - (table.x + table.y));
  r.more = r.once * mean * lost / (vec3(1.0f, 1.0f, 1.0f) - mean * lost);
  return r;
}

// Lagarde and de Rousiers 2014 (Moving Frostbite to Physically Based Rendering, listing 26): ambient occlusion as the
// reflected lobe sees it.
SH_FUNC float specularOcclusion(float nv, float ao, float alpha) {
  return saturate(pow(nv + ao, exp2(-16.0f * alpha - 1.0f)) - 1.0f + ao);
}

// Radiance leaving `s` towards the eye by the environment.
//   diffuseRadiance   irradiance / pi about the normal
//   specularRadiance  prefiltered along the reflected ray
//   table             split-sum scale and bias of f0 and f90 at (n.v, roughness)
SH_FUNC vec3 shadeEnvironment(Surface s, vec3 toEye, vec3 diffuseRadiance, vec3 specularRadiance, vec2 table) {
  EnvironmentReflectance dielectric = environmentReflectance(s.f0, s.f90, table);
  EnvironmentReflectance metal = environmentReflectance(s.baseColor, 1.0f, table);
  vec3 once = dielectric.once + (metal.once - dielectric.once) * s.metallic;
  vec3 more = dielectric.more + (metal.more - dielectric.more) * s.metallic;
  vec3 diffuse = diffuseColor(s) * saturate(1.0f - maxChannel(dielectric.once + dielectric.more));
  float nv = clamp(dot(s.normal, toEye), kMinNv, 1.0f);
  float occlusion = specularOcclusion(nv, s.ao, ggxAlpha(s.roughness));
  return (diffuse + more) * diffuseRadiance * s.ao + once * specularRadiance * occlusion;
}

SH_END

#endif
