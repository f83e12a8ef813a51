// Shading: outgoing radiance of a Surface lit by a punctual light or an environment (glTF 2.0, appendix B). Every
// lighting technique uses only these functions.
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
SH_CONST uint kShadingGgxCompensated = 2u;

// The minimum n.v: interpolated and mapped normals may point away from the eye.
SH_CONST float kMinNv = 1e-4f;

// The part of a surface's BRDF toward one eye that does not depend on the light; computed once per surface.
struct SurfaceBrdf {
  vec3 normal;    // unit
  vec3 toEye;     // unit
  float nv;       // n.v, at least kMinNv
  vec3 diffuse;   // 1/sr, before the Fresnel term is subtracted
  float taken0;   // Fresnel term subtracted at normal incidence
  float taken90;  // Fresnel term subtracted at grazing incidence
  vec3 f0;        // reflectance of the specular lobe at normal incidence
  float f90;      // reflectance of the specular lobe at grazing incidence
  float width;    // width of the lobe: alpha^2, or Blinn-Phong's exponent
  float scale;    // scale of the lobe: the eye's part of Smith masking, or Blinn-Phong's normalization
};

// glTF 2.0, appendix B: mix(dielectric, metal, metallic), where both share one specular lobe. The dielectric's diffuse
// part is scaled by 1 - the largest channel of its Fresnel term (KHR_materials_specular). Schlick's term is linear in
// f0 and f90, so the term of the mixture is the mixture of both terms, and its largest channel is that of the largest
// f0. With energy compensation, s.scattered replaces everything except the single reflection.
SH_FUNC SurfaceBrdf ggxBrdf(Surface s, vec3 toEye, uint shading) {
  SurfaceBrdf b;
  b.normal = s.normal;
  b.toEye = toEye;
  b.nv = clamp(dot(s.normal, toEye), kMinNv, 1.0f);
  bool compensated = shading == kShadingGgxCompensated;
  b.diffuse = (compensated ? s.scattered : diffuseColor(s)) * kInvPi;
  b.taken0 = compensated ? 0.0f : maxChannel(s.f0);
  b.taken90 = compensated ? 0.0f : s.f90;
  b.f0 = specularF0(s);
  b.f90 = specularF90(s);
  float alpha = ggxAlpha(s.roughness);
  b.width = alpha * alpha;
  b.scale = smithRoot(b.nv, b.width);
  return b;
}

// Diffuse and specular colors with one normalized Blinn-Phong lobe and without a Fresnel term. The diffuse part of a
// dielectric is reduced by its specular color, so that no surface reflects more than it receives at normal incidence.
SH_FUNC SurfaceBrdf blinnPhongBrdf(Surface s, vec3 toEye) {
  SurfaceBrdf b = ggxBrdf(s, toEye, kShadingBlinnPhong);
  b.width = exponentFromRoughness(s.roughness);
  b.scale = blinnPhongScale(b.width);
  return b;
}

SH_FUNC SurfaceBrdf surfaceBrdf(Surface s, vec3 toEye, uint shading) {
  if (shading == kShadingBlinnPhong) return blinnPhongBrdf(s, toEye);
  return ggxBrdf(s, toEye, shading);
}

// Radiance toward the eye from one light. Branch-free: lanes would diverge, so the contribution of lights behind the
// surface is multiplied by zero instead.
SH_FUNC vec3 shadeLight(SurfaceBrdf b, LightSample light, uint shading) {
  float nl = saturate(dot(b.normal, light.toLight));
  HalfAngles a = halfAngles(b.normal, light.toLight, b.toEye);
  float weight = 0.0f, lobe;
  if (shading == kShadingBlinnPhong) {
    lobe = blinnPhong(a.nh, a.sin2, b.width, b.scale);
  } else {
    weight = schlickWeight(a.vh);
    lobe = ggxLobe(a, nl, b.nv, b.width, b.scale);
  }
  vec3 fresnel = b.f0 + (vec3(b.f90, b.f90, b.f90) - b.f0) * weight;
  float left = 1.0f - (b.taken0 + (b.taken90 - b.taken0) * weight);
  return (b.diffuse * left + fresnel * lobe) * (light.intensity * (light.attenuation * nl));
}

// Fractions of uniform light from all directions that a microfacet surface with reflectance f0 to f90 reflects toward
// the eye: `once` by single reflection, and `more` by multiple reflections between facets, which leave the surface with
// a nearly Lambertian distribution.
//
// Light that a white surface does not reflect in one bounce hits a second facet, and then further facets with a
// probability that grows with roughness. According to a random walk over Smith's surface (Heitz et al. 2016,
// Multiple-Scattering Microfacet BSDFs with the Smith Model), this probability is 3/4 of that lost fraction. White
// surfaces therefore return all light, as in Fdez-Aguera (2019, A Multiple-Scattering Microfacet Model for Real-Time
// Image Based Lighting, JCGT 8(1)). That paper's own series, which uses 1 - E as the probability of every bounce from
// the second on, makes colored surfaces up to 9 % darker than the walk.
struct Reflectance {
  vec3 once;
  vec3 more;
};
// The multiple reflections. `mean` is the facets' mean reflectance for light from all directions, `lost` the fraction
// that white facets do not reflect in one bounce.
SH_FUNC vec3 reflectedMore(vec3 mean, float lost) {
  float again = 0.75f * lost;
  return mean * mean * (lost * (1.0f - again)) / (vec3(1.0f, 1.0f, 1.0f) - mean * again);
}
SH_FUNC Reflectance reflectance(vec3 f0, float f90, vec2 table) {
  Reflectance r;
  r.once = f0 * table.x + vec3(f90, f90, f90) * table.y;
  // Cosine-weighted mean of Schlick's term over the hemisphere: f0 + (f90 - f0) / 21.
  vec3 mean = f0 + (vec3(f90, f90, f90) - f0) * (1.0f / 21.0f);
  r.more = reflectedMore(mean, saturate(1.0f - (table.x + table.y)));
  return r;
}

// Fractions of uniform light for a mixed surface. `scattered` is the Lambertian part: multiple reflections between
// facets, and the diffuse part, which receives the light that is not reflected.
struct SurfaceReflectance {
  vec3 once;
  vec3 scattered;
};
SH_FUNC SurfaceReflectance surfaceReflectance(Surface s, vec2 table) {
  Reflectance dielectric = reflectance(s.f0, s.f90, table);
  Reflectance metal = reflectance(s.baseColor, 1.0f, table);
  SurfaceReflectance r;
  r.once = dielectric.once + (metal.once - dielectric.once) * s.metallic;
  vec3 more = dielectric.more + (metal.more - dielectric.more) * s.metallic;
  r.scattered = more + diffuseColor(s) * saturate(1.0f - maxChannel(dielectric.once + dielectric.more));
  return r;
}

// Lagarde and de Rousiers 2014 (Moving Frostbite to Physically Based Rendering, listing 26): specular occlusion from
// ambient occlusion.
SH_FUNC float specularOcclusion(float nv, float ao, float alpha) {
  return saturate(pow(nv + ao, exp2(-16.0f * alpha - 1.0f)) - 1.0f + ao);
}

// Radiance from `s` toward the eye due to the environment (image-based lighting with the split-sum approximation).
//   diffuseRadiance   irradiance / pi about the normal
//   specularRadiance  mean over the reflected lobe
//   table             split-sum scale and bias of f0 and f90 at (n.v, roughness)
SH_FUNC vec3 shadeEnvironment(Surface s, vec3 toEye, vec3 diffuseRadiance, vec3 specularRadiance, vec2 table) {
  SurfaceReflectance r = surfaceReflectance(s, table);
  float nv = clamp(dot(s.normal, toEye), kMinNv, 1.0f);
  float occlusion = specularOcclusion(nv, s.ao, ggxAlpha(s.roughness));
  return r.scattered * diffuseRadiance * s.ao + r.once * specularRadiance * occlusion;
}

SH_END

#endif
