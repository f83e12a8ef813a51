// Shading with area lights: the radiance that a surface, with or without coats, reflects from a shape, if nothing
// blocks it. The lobes are those of shade.h and layers.h, whose integrals are computed by area_light.h.
//
// The Lambertian part is exact except for the light that the specular lobe takes from it, which is evaluated for the
// mean direction to the light. The specular part has the error of the fits (docs/light.md). Blinn-Phong's lobe is
// replaced by the GGX lobe of the same width, and an anisotropic lobe by a round one.
#ifndef LATELIGHT_SHARED_SHADE_AREA_H
#define LATELIGHT_SHARED_SHADE_AREA_H

#include "shared/area_light.h"
#include "shared/layers.h"
#include "shared/shade.h"

SH_BEGIN

// The lobes of a surface toward one eye.
struct AreaLobes {
  LobeAxes cosine;
  LobeAxes mirror;  // of the specular lobe
  float albedo;     // fraction of uniform light that the specular lobe reflects, without Fresnel
  vec3 specular;    // with Fresnel
};

// `reflected`: SurfaceReflectance::once. `table`: the split-sum table, and `fit`: the fitted lobe at (n.v, roughness).
SH_FUNC AreaLobes areaLobes(SurfaceBrdf b, vec3 reflected, vec2 table, LtcFit fit, uint shading) {
  AreaLobes lobes;
  lobes.cosine = cosineAxes(b.normal);
  lobes.mirror = fittedAxes(b.normal, b.toEye, fit);
  lobes.albedo = saturate(table.x + table.y);
  lobes.specular = reflected;
  if (shading == kShadingBlinnPhong) {
    lobes.albedo = 1.0f;
    lobes.specular = b.f0;
  }
  return lobes;
}

// The direction of an integral in the frame of `axes`, which are orthonormal; the normal if there is no light.
SH_FUNC vec3 directionOf(LobeAxes axes, vec3 integral) {
  vec3 direction = axes.x * integral.x + axes.y * integral.y + axes.z * integral.z;
  float squared = dot(direction, direction);
  if (squared < 1e-30f) return axes.z;
  return direction * inversesqrt(max(squared, 1e-30f));
}

// The world's direction of an integral in the frame of a fitted lobe.
SH_FUNC vec3 lobeDirection(LobeAxes axes, vec3 integral) {
  vec3 direction =
      cross(axes.y, axes.z) * integral.x + cross(axes.z, axes.x) * integral.y + cross(axes.x, axes.y) * integral.z;
  return direction * inversesqrt(max(dot(direction, direction), 1e-30f));
}

// Cosine between the half vector and either of two directions.
SH_FUNC float halfCosine(vec3 toLight, vec3 toEye) {
  return sqrt(saturate(0.5f + 0.5f * dot(toLight, toEye)));
}

// The part of the specular lobe that an area light fills, and the light's mean direction there.
struct MirroredArea {
  float share;
  vec3 toLight;
};
SH_FUNC MirroredArea mirroredArea(AreaLobes lobes, vec3 integral) {
  MirroredArea m;
  m.share = saturate(integral.z * lobes.mirror.scale);
  m.toLight = lobeDirection(lobes.mirror, integral);
  return m;
}

// The reflected fraction of a light's radiance, for the reflectance of facets between its mean direction and the eye.
// Light that fills the lobe has the lobe's mean.
SH_FUNC vec3 reflectedShare(AreaLobes lobes, MirroredArea m, vec3 facets) {
  return (facets * lobes.albedo * (1.0f - m.share) + lobes.specular * m.share) * m.share;
}

// Radiance toward the eye through the Lambertian part and through the specular lobe.
struct AreaReflection {
  vec3 scattered;
  vec3 mirrored;
};
SH_FUNC AreaReflection reflectArea(SurfaceBrdf b, AreaLobes lobes, AreaLight light, vec3 position, uint shading) {
  Outline outline = outlineOf(light, position);
  vec3 integral = vec3(0.0f, 0.0f, 0.0f), mirrored = integral;
  for (uint i = 0u; i < 2u; ++i) {  // one copy of the integral
    LobeAxes axes = lobes.cosine;
    if (i == 1u) axes = lobes.mirror;
    vec3 found = outlineIntegral(light, outline, axes);
    if (i == 0u) integral = found;
    if (i == 1u) mirrored = found;
  }
  MirroredArea m = mirroredArea(lobes, mirrored);
  float weight = schlickWeight(halfCosine(directionOf(lobes.cosine, integral), b.toEye));
  float mirroredWeight = schlickWeight(halfCosine(m.toLight, b.toEye));
  if (shading == kShadingBlinnPhong) {
    weight = 0.0f;
    mirroredWeight = 0.0f;
  }
  float left = 1.0f - (b.taken0 + (b.taken90 - b.taken0) * weight);
  AreaReflection r;
  r.scattered = b.diffuse * light.radiance * (kPi * saturate(integral.z) * left);
  r.mirrored = reflectedShare(lobes, m, b.f0 + (vec3(b.f90, b.f90, b.f90) - b.f0) * mirroredWeight) * light.radiance;
  return r;
}
SH_FUNC vec3 shadeArea(SurfaceBrdf b, AreaLobes lobes, AreaLight light, vec3 position, uint shading) {
  AreaReflection r = reflectArea(b, lobes, light, position, shading);
  return r.scattered + r.mirrored;
}

// --- layered materials -----------------------------------------------------------------------------------------------

// The lobes of a layered surface in addition to AreaLobes.
struct LayeredAreaLobes {
  AreaLobes base;
  LobeAxes coat;     // the clearcoat's lobe
  LobeAxes back;     // the cosine on the back side
  LobeAxes through;  // the transmission lobe
  float throughAlbedo;
};

// The eye's direction mirrored by the surface's plane, after refraction: the transmission lobe is the reflection lobe
// about the negated normal for this eye.
SH_FUNC vec3 eyeBehind(LayeredBrdf b) {
  vec3 eye = eyeThrough(b.base.normal, b.base.toEye, b.layers, 1u);
  return eye - b.base.normal * (2.0f * dot(b.base.normal, eye));
}

// The integrals of a light over the lobes of a layered surface.
struct LayeredAreaIntegrals {
  vec3 cosine;
  vec3 mirror;
  vec3 coat;
  vec3 back;
  vec3 through;
};
SH_FUNC LayeredAreaIntegrals layeredIntegrals(LayeredBrdf b, LayeredAreaLobes lobes, AreaLight light) {
  Outline outline = outlineOf(light, b.surface.position);
  LayeredAreaIntegrals r;
  r.cosine = vec3(0.0f, 0.0f, 0.0f);
  r.mirror = r.cosine;
  r.coat = r.cosine;
  r.back = r.cosine;
  r.through = r.cosine;
  for (uint i = 0u; i < 5u; ++i) {  // one copy of the integral
    bool used = i < 2u;
    LobeAxes axes = lobes.base.cosine;
    if (i == 1u) axes = lobes.base.mirror;
    if (i == 2u) {
      axes = lobes.coat;
      used = b.coatReflects > 0.0f;
    }
    if (i == 3u) {
      axes = lobes.back;
      used = passesLight(b.layers);
    }
    if (i == 4u) {
      axes = lobes.through;
      used = b.layers.transmission > 0.0f;
    }
    vec3 found = vec3(0.0f, 0.0f, 0.0f);
    if (used) found = outlineIntegral(light, outline, axes);
    if (i == 0u) r.cosine = found;
    if (i == 1u) r.mirror = found;
    if (i == 2u) r.coat = found;
    if (i == 3u) r.back = found;
    if (i == 4u) r.through = found;
  }
  return r;
}

// Light that an area light behind the surface transmits, as lightFromBackSide() defines.
SH_FUNC vec3 areaFromBackSide(LayeredBrdf b, LayeredAreaLobes lobes, LayeredAreaIntegrals found, vec3 radiance) {
  vec3 toLight = directionOf(lobes.back, found.back);
  vec3 mirrored = toLight - b.base.normal * (2.0f * dot(b.base.normal, toLight));
  float left = 1.0f;
  if (b.compensated <= 0.0f) left = facetReflectance(b, halfCosine(mirrored, b.base.toEye)).left;
  vec3 sum = b.backDiffuse * (kPi * saturate(found.back.z));
  sum = sum + b.through * (lobes.throughAlbedo * saturate(found.through.z * lobes.through.scale));
  return sum * radiance * left;
}

// Sheen is so wide that the light of a shape is that of its mean direction.
SH_FUNC vec3 areaSheen(LayeredBrdf b, vec3 toLight, vec3 radiance, float share) {
  LightSample arriving;
  arriving.toLight = toLight;
  arriving.intensity = radiance;
  arriving.attenuation = kPi * share / max(dot(b.base.normal, toLight), 1e-3f);
  return sheenLight(b, arriving);
}

SH_FUNC vec3 shadeLayeredArea(LayeredBrdf b, LayeredAreaLobes lobes, AreaLight light, uint shading) {
  LayeredAreaIntegrals found = layeredIntegrals(b, lobes, light);
  vec3 toLight = directionOf(lobes.base.cosine, found.cosine);
  MirroredArea m = mirroredArea(lobes.base, found.mirror);
  float share = saturate(found.cosine.z);
  float left = 1.0f - b.base.taken0;
  vec3 facets = b.base.f0;
  if (shading != kShadingBlinnPhong) {
    left = facetReflectance(b, halfCosine(toLight, b.base.toEye)).left;
    facets = facetReflectance(b, halfCosine(m.toLight, b.base.toEye)).lobe;
  }
  vec3 radiance = b.base.diffuse * (kPi * share * left) + reflectedShare(lobes.base, m, facets);
  radiance = radiance * light.radiance * b.under;
  if (maxChannel(b.layers.sheenColor) > 0.0f) radiance = radiance + areaSheen(b, toLight, light.radiance, share);
  float coat = b.coatReflects * b.coatAlbedo * saturate(found.coat.z * lobes.coat.scale);
  radiance = radiance + light.radiance * coat;
  if (passesLight(b.layers)) radiance = radiance + areaFromBackSide(b, lobes, found, light.radiance) * b.under;
  return radiance;
}

SH_END

#endif
