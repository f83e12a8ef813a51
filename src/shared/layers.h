// Shading of layered materials (coats) and transmission: glTF's KHR_materials_clearcoat, sheen, anisotropy,
// iridescence, transmission, volume, dispersion and diffuse_transmission. From top to bottom, a material consists of
// clearcoat, sheen, and the surface of shade.h, whose lobe may be anisotropic and have a thin film on it, and whose
// diffuse part may transmit light. A layer of strength 0 leaves the result of shade.h unchanged, to the bit.
//
// Choices where the specifications allow several: a clearcoat attenuates the layers below by weight * Fresnel(n.v), as
// specified. Under an environment or with energy compensation it attenuates them by exactly what its lobe reflects, so
// white under any coat stays white. Sheen attenuates by max(color) * E(n.v). Both depend only on the direction to the
// eye, so they are not reciprocal. With kShadingBlinnPhong the surface's lobe is isotropic and has no film; the layers
// above and the transmitted light are the same.
#ifndef LATELIGHT_SHARED_LAYERS_H
#define LATELIGHT_SHARED_LAYERS_H

#include "shared/brdf/anisotropic.h"
#include "shared/brdf/charlie.h"
#include "shared/brdf/thin_film.h"
#include "shared/brdf/transmission.h"
#include "shared/shade.h"

SH_BEGIN

// Layer parameters as evaluated at a point. Directions are unit vectors in world space.
struct SurfaceLayers {
  float clearcoat;  // [0, 1]
  float clearcoatRoughness;
  vec3 clearcoatNormal;
  vec3 sheenColor;  // [0, 1]
  float sheenRoughness;
  float anisotropy;          // strength, [0, 1]
  vec3 anisotropyDirection;  // stretch direction of the highlight, perpendicular to the surface's normal
  float iridescence;         // [0, 1]
  float iridescenceIor;
  float iridescenceThickness;  // nm
  float ior;                   // index of refraction of the surface and the medium below it, at least 1
  float transmission;          // [0, 1]
  float thickness;             // thickness of a volume, m; 0: thin-walled
  vec3 absorption;             // 1/m: absorptionOf()
  float dispersion;            // 20 / Abbe number
  float diffuseTransmission;   // [0, 1]
  vec3 diffuseTransmissionColor;
};

SH_FUNC SurfaceLayers emptyLayers() {
  SurfaceLayers l;
  l.clearcoat = 0.0f;
  l.clearcoatRoughness = 0.0f;
  l.clearcoatNormal = vec3(0.0f, 0.0f, 1.0f);
  l.sheenColor = vec3(0.0f, 0.0f, 0.0f);
  l.sheenRoughness = 0.0f;
  l.anisotropy = 0.0f;
  l.anisotropyDirection = vec3(1.0f, 0.0f, 0.0f);
  l.iridescence = 0.0f;
  l.iridescenceIor = 1.3f;
  l.iridescenceThickness = 400.0f;
  l.ior = 1.5f;
  l.transmission = 0.0f;
  l.thickness = 0.0f;
  l.absorption = vec3(0.0f, 0.0f, 0.0f);
  l.dispersion = 0.0f;
  l.diffuseTransmission = 0.0f;
  l.diffuseTransmissionColor = vec3(1.0f, 1.0f, 1.0f);
  return l;
}

// Per lobe, first the position in the split-sum table, (n.v, perceptual roughness), and later the table's value there.
struct LayerTables {
  vec2 base;
  vec2 coat;
  vec2 behind;
};

// The part of a layered surface's BRDF that does not depend on the light; computed once per surface.
struct LayeredBrdf {
  SurfaceBrdf base;
  Surface surface;       // inputs of the thin film and of environment lighting
  SurfaceLayers layers;  // clamped to their ranges
  StretchedFrame stretched;
  float compensated;   // 1: punctual lights include multiple scattering between facets (energy compensation)
  float under;         // transmittance of clearcoat and sheen for punctual light
  float underAverage;  // transmittance for an environment's light
  float coatNv;        // cosine between the coat's normal and the eye
  float coatA2;        // alpha^2 of the coat
  float coatRoot;      // smithRoot() of both
  float coatReflects;  // weight * Fresnel
  float coatAlbedo;    // fraction of uniform light that its lobe reflects, without Fresnel
  float sheenAlpha;
  float sheenLambda;  // charlieLambda() of the eye's direction
  float sheenScale;   // keeps the lobe from reflecting more than it receives
  float sheenAlbedo;
  float underCoat;         // transmittance of the clearcoat for punctual light, above the sheen
  float underCoatAverage;  // transmittance of the clearcoat for an environment's light
  vec3 once;               // fraction of an environment's light that the surface's lobe reflects
  vec3 scattered;          // fraction that the surface scatters diffusely
  vec3 behind;             // fraction that the surface transmits diffusely
  vec3 seen;               // fraction of the transmission background's radiance that is visible through the surface
  vec3 backDiffuse;        // 1/sr, diffuse transmission of light from the back side, before the Fresnel term is
                           // subtracted
  vec3 through;            // factor of the transmission lobe for light from the back side, likewise
  float throughA2;         // alpha^2 of the transmission lobe
};

SH_FUNC SurfaceLayers clampedLayers(SurfaceLayers l) {
  l.clearcoat = saturate(l.clearcoat);
  l.sheenColor = vec3(saturate(l.sheenColor.x), saturate(l.sheenColor.y), saturate(l.sheenColor.z));
  l.anisotropy = saturate(l.anisotropy);
  l.iridescence = saturate(l.iridescence);
  l.ior = max(l.ior, 1.0f);
  l.transmission = saturate(l.transmission);
  l.thickness = max(l.thickness, 0.0f);
  l.dispersion = max(l.dispersion, 0.0f);
  l.diffuseTransmission = saturate(l.diffuseTransmission);
  return l;
}

SH_FUNC bool passesLight(SurfaceLayers l) {
  return l.transmission > 0.0f || l.diffuseTransmission > 0.0f;
}

// Fraction of the diffuse part that is still reflected to the eye's side.
SH_FUNC float keptDiffuse(SurfaceLayers l) {
  return (1.0f - l.transmission) * (1.0f - l.diffuseTransmission);
}

// The direction from which light passes through the surface to the eye without scattering, negated: the eye's direction
// for a thin wall, the refracted one for a volume.
SH_FUNC vec3 eyeThrough(vec3 normal, vec3 toEye, SurfaceLayers l, uint channel) {
  if (l.thickness <= 0.0f) return toEye;
  float nv = clamp(dot(normal, toEye), kMinNv, 1.0f);
  return refractedRay(normal, toEye, nv, dispersedIor(max(l.ior, 1.0f), l.dispersion, channel)) * -1.0f;
}

// The positions at which layeredBrdf() requires the split-sum table.
SH_FUNC LayerTables layerTableCoordinates(Surface s, SurfaceLayers l, vec3 toEye) {
  LayerTables t;
  t.base = vec2(saturate(dot(s.normal, toEye)), s.roughness);
  t.coat = vec2(saturate(dot(l.clearcoatNormal, toEye)), saturate(l.clearcoatRoughness));
  t.behind =
      vec2(saturate(dot(s.normal, eyeThrough(s.normal, toEye, l, 1u))), transmittedRoughness(s.roughness, l.ior));
  return t;
}

// Mean thin-film reflectance over facets at those angles, from two facets at one standard deviation from the mean.
SH_FUNC vec3 meanThinFilm(vec3 f0, SurfaceLayers l, FacetCosines c) {
  vec3 low = thinFilm(f0, l.iridescenceIor, l.iridescenceThickness, saturate(c.mean - c.spread));
  vec3 high = thinFilm(f0, l.iridescenceIor, l.iridescenceThickness, saturate(c.mean + c.spread));
  return (low + high) * 0.5f;
}

// reflectance() of a surface with a thin film.
SH_FUNC Reflectance filmedReflectance(vec3 f0, float f90, vec2 table, SurfaceLayers l, float nv, float alpha) {
  Reflectance r = reflectance(f0, f90, table);
  if (l.iridescence <= 0.0f) return r;
  FacetCosines facets = facetCosines(nv, alpha);
  FacetCosines all;  // for light from all directions, where cosines have the density 2 x
  all.mean = 2.0f / 3.0f;
  all.spread = 0.2357f;
  float albedo = table.x + table.y;
  vec3 more = reflectedMore(meanThinFilm(f0, l, all), saturate(1.0f - albedo));
  r.once = r.once + (meanThinFilm(f0, l, facets) * albedo - r.once) * l.iridescence;
  r.more = r.more + (more - r.more) * l.iridescence;
  return r;
}

// Fractions of uniform light from all directions that the surface's lobe reflects, as in surfaceReflectance().
struct LobeReflectance {
  vec3 once;
  vec3 more;
  vec3 dielectric;  // both, of the part that is not metallic
};
SH_FUNC LobeReflectance lobeReflectance(LayeredBrdf b, vec3 toEye, vec2 table) {
  Surface s = b.surface;
  SurfaceLayers l = b.layers;
  float nv = saturate(dot(s.normal, toEye));
  float alpha = ggxAlpha(s.roughness);
  Reflectance dielectric = filmedReflectance(s.f0, s.f90, table, l, nv, alpha);
  Reflectance metal = filmedReflectance(s.baseColor, 1.0f, table, l, nv, alpha);
  LobeReflectance r;
  r.once = dielectric.once + (metal.once - dielectric.once) * s.metallic;
  r.more = dielectric.more + (metal.more - dielectric.more) * s.metallic;
  r.dielectric = dielectric.once + dielectric.more;
  return r;
}

// Computes the fractions of uniform light that the surface itself reflects, scatters and transmits.
SH_FUNC void addReflectance(SH_INOUT(LayeredBrdf) b, LobeReflectance r) {
  Surface s = b.surface;
  SurfaceLayers l = b.layers;
  b.once = r.once;
  float left = saturate(1.0f - maxChannel(r.dielectric));
  b.scattered = r.more + diffuseColor(s) * left * keptDiffuse(l);
  b.behind = vec3(0.0f, 0.0f, 0.0f);
  b.seen = b.behind;
  if (!passesLight(l)) return;
  vec3 passed = beersLaw(l.absorption, l.thickness) * ((1.0f - s.metallic) * left);
  b.behind = l.diffuseTransmissionColor * passed * ((1.0f - l.transmission) * l.diffuseTransmission);
  b.seen = s.baseColor * passed * l.transmission;
}

// Computes the transmission factors for punctual lights. With energy compensation, they follow from the factors for
// uniform light.
SH_FUNC void addTransmission(SH_INOUT(LayeredBrdf) b, vec2 table) {
  Surface s = b.surface;
  SurfaceLayers l = b.layers;
  b.throughA2 = 1.0f;
  b.backDiffuse = vec3(0.0f, 0.0f, 0.0f);
  b.through = b.backDiffuse;
  if (!passesLight(l)) return;
  float alpha = ggxAlpha(transmittedRoughness(s.roughness, l.ior));
  b.throughA2 = alpha * alpha;
  if (b.compensated > 0.0f) {
    b.backDiffuse = b.behind * kInvPi;
    b.through = b.seen / max(table.x + table.y, 0.1f);
    return;
  }
  vec3 passed = beersLaw(l.absorption, l.thickness) * (1.0f - s.metallic);
  b.backDiffuse = l.diffuseTransmissionColor * passed * ((1.0f - l.transmission) * l.diffuseTransmission * kInvPi);
  b.through = s.baseColor * passed * l.transmission;
}

SH_FUNC void addCoat(SH_INOUT(LayeredBrdf) b, vec2 table) {
  SurfaceLayers l = b.layers;
  b.coatNv = 1.0f;
  b.coatA2 = 1.0f;
  b.coatRoot = 1.0f;
  b.coatReflects = 0.0f;
  b.coatAlbedo = 0.0f;
  b.underCoat = 1.0f;
  b.underCoatAverage = 1.0f;
  if (l.clearcoat <= 0.0f) return;
  float alpha = ggxAlpha(saturate(l.clearcoatRoughness));
  b.coatNv = clamp(dot(l.clearcoatNormal, b.base.toEye), kMinNv, 1.0f);
  b.coatA2 = alpha * alpha;
  b.coatRoot = smithRoot(b.coatNv, b.coatA2);
  b.coatReflects = l.clearcoat * (0.04f + 0.96f * schlickWeight(b.coatNv));
  b.coatAlbedo = saturate(table.x + table.y);
  b.underCoatAverage = 1.0f - b.coatReflects * b.coatAlbedo;
  b.underCoat = b.compensated > 0.0f ? b.underCoatAverage : 1.0f - b.coatReflects;
}

// Where the lobe would reflect more than it receives (charlieAlbedo()), it is scaled to reflect everything.
SH_FUNC void addSheen(SH_INOUT(LayeredBrdf) b) {
  SurfaceLayers l = b.layers;
  b.sheenAlpha = 1.0f;
  b.sheenLambda = 0.0f;
  b.sheenScale = 1.0f;
  b.sheenAlbedo = 0.0f;
  b.under = b.underCoat;
  b.underAverage = b.underCoatAverage;
  if (maxChannel(l.sheenColor) <= 0.0f) return;
  b.sheenAlpha = charlieAlpha(l.sheenRoughness);
  b.sheenLambda = charlieLambda(b.base.nv, b.sheenAlpha);
  float albedo = charlieAlbedo(b.base.nv, l.sheenRoughness);
  b.sheenScale = 1.0f / max(albedo, 1.0f);
  b.sheenAlbedo = min(albedo, 1.0f);
  float left = 1.0f - maxChannel(l.sheenColor) * b.sheenAlbedo;
  b.under = b.underCoat * left;
  b.underAverage = b.underCoatAverage * left;
}

// `tables` holds the values of the split-sum table at layerTableCoordinates().
SH_FUNC LayeredBrdf layeredBrdf(Surface s, SurfaceLayers l, vec3 toEye, uint shading, LayerTables tables) {
  LayeredBrdf b;
  b.surface = s;
  b.layers = clampedLayers(l);
  b.compensated = shading == kShadingGgxCompensated ? 1.0f : 0.0f;
  b.stretched = stretchedFrame(s.normal, l.anisotropyDirection, s.roughness, b.layers.anisotropy);
  if (b.layers.anisotropy > 0.0f)
    tables.base = stretchedTable(b.stretched, toEye, clamp(dot(s.normal, toEye), kMinNv, 1.0f));
  addReflectance(b, lobeReflectance(b, toEye, tables.base));
  s.scattered = b.scattered;
  b.base = surfaceBrdf(s, toEye, shading);
  if (b.compensated <= 0.0f) b.base.diffuse = b.base.diffuse * keptDiffuse(b.layers);
  addTransmission(b, tables.behind);
  addCoat(b, tables.coat);
  addSheen(b);
  return b;
}

// Emission is below the clearcoat, which attenuates it.
SH_FUNC vec3 coatedEmission(LayeredBrdf b, vec3 emitted) {
  return emitted * (1.0f - b.coatReflects);
}

// --- punctual lights -------------------------------------------------------------------------------------------------

// Reflectance of the surface's facets, and the fraction of light that remains for its diffuse part.
struct FacetReflectance {
  vec3 lobe;
  float left;
};
SH_FUNC FacetReflectance facetReflectance(LayeredBrdf b, float vh) {
  FacetReflectance r;
  float weight = schlickWeight(vh);
  r.lobe = b.base.f0 + (vec3(b.base.f90, b.base.f90, b.base.f90) - b.base.f0) * weight;
  r.left = 1.0f - (b.base.taken0 + (b.base.taken90 - b.base.taken0) * weight);
  SurfaceLayers l = b.layers;
  if (l.iridescence <= 0.0f) return r;
  Surface s = b.surface;
  vec3 dielectric = schlick(s.f0, s.f90, vh);
  vec3 metal = schlick(s.baseColor, 1.0f, vh);
  dielectric = dielectric + (thinFilm(s.f0, l.iridescenceIor, l.iridescenceThickness, vh) - dielectric) * l.iridescence;
  metal = metal + (thinFilm(s.baseColor, l.iridescenceIor, l.iridescenceThickness, vh) - metal) * l.iridescence;
  r.lobe = dielectric + (metal - dielectric) * s.metallic;
  r.left = b.compensated > 0.0f ? 1.0f : 1.0f - maxChannel(dielectric);
  return r;
}

// The half vector; 0 if the light is exactly opposite the eye.
SH_FUNC vec3 halfVector(vec3 toLight, vec3 toEye) {
  vec3 sum = toLight + toEye;
  float squared = dot(sum, sum);
  return sum * (squared > 1e-12f ? inversesqrt(squared) : 0.0f);
}

// Radiance that the surface below clearcoat and sheen reflects.
SH_FUNC vec3 surfaceLight(LayeredBrdf b, LightSample light, uint shading) {
  bool plain = b.layers.anisotropy <= 0.0f && b.layers.iridescence <= 0.0f;
  if (plain || shading == kShadingBlinnPhong) return shadeLight(b.base, light, shading);
  float nl = min(dot(b.base.normal, light.toLight), 1.0f);
  if (nl <= 0.0f) return vec3(0.0f, 0.0f, 0.0f);
  HalfAngles angles = halfAngles(b.base.normal, light.toLight, b.base.toEye);
  FacetReflectance facets = facetReflectance(b, saturate(angles.vh));
  float lobe;
  if (b.layers.anisotropy > 0.0f) {
    vec3 h = halfVector(light.toLight, b.base.toEye);
    lobe = stretchedLobe(b.stretched, light.toLight, b.base.toEye, h, nl, b.base.nv);
  } else {
    lobe = ggxLobe(angles, nl, b.base.nv, b.base.width, b.base.scale);
  }
  return (b.base.diffuse * facets.left + facets.lobe * lobe) * (light.intensity * (light.attenuation * nl));
}

// 1/sr, the transmission lobe: the reflection lobe for the light direction `mirrored` by the surface's plane.
SH_FUNC float throughLobe(LayeredBrdf b, vec3 mirrored, float nl, uint channel) {
  vec3 eye = eyeThrough(b.base.normal, b.base.toEye, b.layers, channel);
  float nv = clamp(dot(b.base.normal, eye), kMinNv, 1.0f);
  return ggxLobe(halfAngles(b.base.normal, mirrored, eye), nl, nv, b.throughA2, smithRoot(nv, b.throughA2));
}

// Radiance that a light on the back side transmits through the surface. `nl` is the cosine on that side.
SH_FUNC vec3 lightFromBackSide(LayeredBrdf b, LightSample light, float nl) {
  vec3 mirrored = light.toLight + b.base.normal * (2.0f * nl);
  vec3 f = b.backDiffuse;
  if (b.layers.transmission > 0.0f) {
    float green = throughLobe(b, mirrored, nl, 1u);
    vec3 lobe = vec3(green, green, green);
    if (b.layers.dispersion > 0.0f && b.layers.thickness > 0.0f)
      lobe = vec3(throughLobe(b, mirrored, nl, 0u), green, throughLobe(b, mirrored, nl, 2u));
    f = f + b.through * lobe;
  }
  float left = 1.0f;
  if (b.compensated <= 0.0f)
    left = facetReflectance(b, saturate(halfAngles(b.base.normal, mirrored, b.base.toEye).vh)).left;
  return f * light.intensity * (light.attenuation * (left * nl));
}

SH_FUNC vec3 coatLight(LayeredBrdf b, LightSample light) {
  float nl = saturate(dot(b.layers.clearcoatNormal, light.toLight));
  HalfAngles angles = halfAngles(b.layers.clearcoatNormal, light.toLight, b.base.toEye);
  float lobe = ggxLobe(angles, nl, b.coatNv, b.coatA2, b.coatRoot);
  return light.intensity * (light.attenuation * (b.coatReflects * lobe * nl));
}

SH_FUNC vec3 sheenLight(LayeredBrdf b, LightSample light) {
  float nl = min(dot(b.base.normal, light.toLight), 1.0f);
  if (maxChannel(b.layers.sheenColor) <= 0.0f || nl <= 0.0f) return vec3(0.0f, 0.0f, 0.0f);
  float sin2 = halfAngles(b.base.normal, light.toLight, b.base.toEye).sin2;
  float lobe = charlieLobe(sin2, nl, b.base.nv, b.sheenAlpha, b.sheenLambda);
  return b.layers.sheenColor * light.intensity * (light.attenuation * (lobe * b.sheenScale * b.underCoat * nl));
}

// Radiance toward the eye from one light, which may be on the back side of the surface.
SH_FUNC vec3 shadeLayeredLight(LayeredBrdf b, LightSample light, uint shading) {
  vec3 radiance = surfaceLight(b, light, shading) * b.under + sheenLight(b, light) + coatLight(b, light);
  float nl = dot(b.base.normal, light.toLight);
  if (nl < 0.0f && passesLight(b.layers))
    radiance = radiance + lightFromBackSide(b, light, min(nl * -1.0f, 1.0f)) * b.under;
  return radiance;
}

// --- environment -----------------------------------------------------------------------------------------------------

// An isotropic lobe samples the environment as an unlayered surface does. For an anisotropic lobe, light is summed over
// this number of directions.
SH_CONST uint kStretchedSamples = 80u;

// A film's reflectance at three cosines, one step apart. A parabola interpolates and extrapolates them.
struct FilmCurve {
  float middle;
  float step;
  vec3 low;
  vec3 mean;
  vec3 high;
};
SH_FUNC vec3 filmReflectance(LayeredBrdf b, float vh) {
  SurfaceLayers l = b.layers;
  vec3 dielectric = thinFilm(b.surface.f0, l.iridescenceIor, l.iridescenceThickness, vh);
  vec3 metal = thinFilm(b.surface.baseColor, l.iridescenceIor, l.iridescenceThickness, vh);
  return dielectric + (metal - dielectric) * b.surface.metallic;
}
SH_FUNC FilmCurve filmCurve(LayeredBrdf b) {
  FacetCosines facets = facetCosines(b.base.nv, sqrt(b.stretched.along * b.stretched.across));
  FilmCurve c;
  c.step = max(1.3f * facets.spread, 0.01f);
  c.middle = clamp(facets.mean, c.step, 1.0f - c.step);
  c.low = vec3(0.0f, 0.0f, 0.0f);
  c.mean = c.low;
  c.high = c.low;
  if (b.layers.iridescence <= 0.0f) return c;
  c.low = filmReflectance(b, c.middle - c.step);
  c.mean = filmReflectance(b, c.middle);
  c.high = filmReflectance(b, c.middle + c.step);
  return c;
}
SH_FUNC vec3 filmAt(FilmCurve c, float vh) {
  float x = clamp((vh - c.middle) / c.step, -1.5f, 1.5f);
  vec3 r = c.mean + (c.high - c.low) * (0.5f * x) + (c.low + c.high - c.mean * 2.0f) * (0.5f * x * x);
  return vec3(saturate(r.x), saturate(r.y), saturate(r.z));
}

// Sums over the directions of an anisotropic lobe: reflected radiance, reflected fraction of uniform light, and
// split-sum scale and bias.
struct StretchedSum {
  vec3 light;
  vec3 shares;
  vec2 table;
};
SH_FUNC StretchedSum emptySum() {
  StretchedSum sum;
  sum.light = vec3(0.0f, 0.0f, 0.0f);
  sum.shares = sum.light;
  sum.table = vec2(0.0f, 0.0f);
  return sum;
}
SH_FUNC LobeSample baseSample(LayeredBrdf b, uint i) {
  return stretchedSample(b.stretched, b.base.toEye, b.base.nv, i, kStretchedSamples);
}
SH_FUNC void addSample(SH_INOUT(StretchedSum) sum, LayeredBrdf b, FilmCurve film, LobeSample r, vec3 radiance) {
  vec3 f = b.base.f0 + (vec3(b.base.f90, b.base.f90, b.base.f90) - b.base.f0) * schlickWeight(r.vh);
  vec3 share = (f + (filmAt(film, r.vh) - f) * b.layers.iridescence) * (r.weight / float(kStretchedSamples));
  sum.light = sum.light + radiance * share;
  sum.shares = sum.shares + share;
  sum.table = sum.table + stretchedShare(r) * (1.0f / float(kStretchedSamples));
}
// Returns the mean radiance over the lobe. The remaining fractions of the environment's light are computed from the
// same directions, so that energy is conserved.
SH_FUNC vec3 meanOfSum(SH_INOUT(LayeredBrdf) b, StretchedSum sum) {
  LobeReflectance r = lobeReflectance(b, b.base.toEye, sum.table);
  r.dielectric = r.dielectric + sum.shares - r.once;  // a film differs, because it is evaluated at other angles
  r.once = sum.shares;
  addReflectance(b, r);
  vec3 least = vec3(1e-6f, 1e-6f, 1e-6f);
  return sum.light / max(sum.shares, least);
}

// Direction to the eye projected into the plane of the normal (unit); an arbitrary one if the eye is straight above.
SH_FUNC vec3 alongEye(vec3 normal, vec3 toEye) {
  vec3 along = toEye - normal * dot(normal, toEye);
  float squared = dot(along, along);
  if (squared > 1e-10f) return along * inversesqrt(squared);
  vec3 other = abs(normal.z) < 0.9f ? vec3(0.0f, 0.0f, 1.0f) : vec3(1.0f, 0.0f, 0.0f);
  return normalize(cross(normal, other));
}

// Results of the environment lookups.
struct LayerLight {
  vec3 front;  // irradiance / pi about the surface's normal
  vec3 back;   // irradiance / pi about the negated normal
  vec3 sheen;  // mean radiance over the sheen's lobe
  vec3 base;   // mean radiance over the surface's lobe
  vec3 coat;   // mean radiance over the clearcoat's lobe
};

// Radiance toward the eye due to the environment, except for what is visible through the surface.
SH_FUNC vec3 shadeLayeredEnvironment(LayeredBrdf b, LayerLight light) {
  float ao = b.surface.ao;
  float occlusion = specularOcclusion(b.base.nv, ao, ggxAlpha(b.surface.roughness));
  vec3 radiance = b.scattered * light.front * ao + b.once * light.base * occlusion;
  if (b.layers.diffuseTransmission > 0.0f) radiance = radiance + b.behind * light.back * ao;
  radiance = radiance * b.underAverage;
  if (b.sheenAlbedo > 0.0f)
    radiance = radiance + b.layers.sheenColor * light.sheen * (b.sheenAlbedo * b.underCoatAverage * ao);
  if (b.coatReflects > 0.0f) {
    float coatOcclusion = specularOcclusion(b.coatNv, ao, sqrt(b.coatA2));
    radiance = radiance + light.coat * (b.coatReflects * b.coatAlbedo * coatOcclusion);
  }
  return radiance;
}

// --- transmission background ----------------------------------------------------------------------------------------

// The ray from the eye that continues through a surface at `position`, at the end of its path through the material.
// Channels 0, 1 and 2 differ with dispersion; otherwise use channel 1 for all.
struct TransmittedRay {
  vec3 exit;
  vec3 direction;   // unit
  float roughness;  // perceptual roughness of the background
};
SH_FUNC bool disperses(LayeredBrdf b) {
  return b.layers.dispersion > 0.0f && b.layers.thickness > 0.0f && b.layers.transmission > 0.0f;
}
SH_FUNC TransmittedRay transmittedRay(LayeredBrdf b, uint channel) {
  TransmittedRay r;
  r.direction = eyeThrough(b.base.normal, b.base.toEye, b.layers, channel) * -1.0f;
  r.exit = b.surface.position + r.direction * b.layers.thickness;
  r.roughness = transmittedRoughness(b.surface.roughness, b.layers.ior);
  return r;
}

// Radiance that reaches the eye from the background radiance `found`: attenuated by clearcoat, sheen and reflection,
// tinted by the surface, and absorbed in its volume.
SH_FUNC vec3 transmittedRadiance(LayeredBrdf b, vec3 found) {
  return b.seen * found * b.underAverage;
}

SH_END

#endif
