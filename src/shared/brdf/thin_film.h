// Thin-film interference of KHR_materials_iridescence: the reflectance of a film over a surface, from the interference
// of the light that the film's two sides reflect, integrated over the spectrum (Belcour and Barla 2017, A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence). It follows the specification's form, with
// Schlick's reflectance without polarization, but sums kFilmOrders orders of the series.
#ifndef LATELIGHT_SHARED_BRDF_THIN_FILM_H
#define LATELIGHT_SHARED_BRDF_THIN_FILM_H

#include "shared/brdf/ggx.h"

SH_BEGIN

// Reflectance at normal incidence between two indices of refraction.
SH_FUNC float reflectanceFromIors(float a, float b) {
  float r = (a - b) / (a + b);
  return r * r;
}

// Index of refraction, relative to air, for a reflectance at normal incidence. For 0.9999 it is 4e4.
SH_FUNC float iorFromReflectance(float f0) {
  float root = sqrt(min(f0, 0.9999f));
  return (1.0f + root) / (1.0f - root);
}

// Linear Rec.709 color of light whose reflected fraction is cos(2 pi path / wavelength + shift): Fourier transforms of
// Gaussians fitted to the color matching functions (the paper's section 4; X has two). `path` is in meters; there is
// one shift each for X, Y and Z. The specification's sums make equal-energy white reddish (1.20, 0.95, 0.91), so a film
// would tint a surface even if it is too thin for interference. Here each channel is scaled by its white.
SH_FUNC vec3 filmSensitivity(float path, vec3 shift) {
  float phase = 2.0f * kPi * path;
  float p2 = phase * phase;
  float x1 = cos(1.6810e6f * phase + shift.x) * exp(-4.3278e9f * p2);
  float x2 = cos(2.2399e6f * phase + shift.x) * exp(-4.5282e9f * p2);
  float y = cos(1.7953e6f * phase + shift.y) * exp(-9.3046e9f * p2);
  float z = cos(2.2084e6f * phase + shift.z) * exp(-6.6121e9f * p2);
  return vec3(2.2759311f * x1 + 0.4136520f * x2 - 1.2755264f * y - 0.4140567f * z,
              -0.8652895f * x1 - 0.1572669f * x2 + 1.9786866f * y + 0.0438699f * z,
              0.0517655f * x1 + 0.0094084f * x2 - 0.2242517f * y + 1.1630777f * z);
}

// Effect of a film on one channel of the surface below, whose reflectance in air is f0.
struct FilmChannel {
  float inner;  // reflectance between film and surface
  float shift;  // phase shift of the light reflected there
};
SH_FUNC FilmChannel filmChannel(float f0, float filmIor, float innerWeight) {
  FilmChannel c;
  float base = iorFromReflectance(f0);
  float r = reflectanceFromIors(base, filmIor);
  c.inner = r + (1.0f - r) * innerWeight;
  c.shift = base < filmIor ? kPi : 0.0f;
  return c;
}

// Two orders, as in the specification, have an error of up to 0.27 in a channel at grazing angles over reflective
// surfaces; three have 0.17.
SH_CONST uint kFilmOrders = 3u;

// Reflectance of a film of that thickness (nm) over a surface of reflectance f0 in air, for light arriving from air at
// `cosine`. Colors outside Rec.709 are clamped, so no channel reflects more than it receives. Schlick's term makes both
// sides of the film reflect at grazing angles regardless of the indices, so films thinner than 0.03 nm are faded out.
SH_FUNC vec3 thinFilm(vec3 f0, float ior, float thickness, float cosine) {
  float film = max(ior, 1.0f);
  float inside2 = 1.0f - (1.0f - cosine * cosine) / (film * film);
  float inside = sqrt(max(inside2, 0.0f));
  float r0 = reflectanceFromIors(film, 1.0f);
  float outer = r0 + (1.0f - r0) * schlickWeight(cosine);
  float passed = 1.0f - outer;
  float innerWeight = schlickWeight(inside);
  FilmChannel r = filmChannel(f0.x, film, innerWeight);
  FilmChannel g = filmChannel(f0.y, film, innerWeight);
  FilmChannel b = filmChannel(f0.z, film, innerWeight);
  vec3 inner = vec3(r.inner, g.inner, b.inner);
  vec3 shift = vec3(kPi + r.shift, kPi + g.shift, kPi + b.shift);
  vec3 both = vec3(min(outer * inner.x, 0.9999f), min(outer * inner.y, 0.9999f), min(outer * inner.z, 0.9999f));
  vec3 root = vec3(sqrt(both.x), sqrt(both.y), sqrt(both.z));
  vec3 series = inner * (passed * passed) / (vec3(1.0f, 1.0f, 1.0f) - both);
  vec3 sum = series + vec3(outer, outer, outer);
  vec3 order = (series - vec3(passed, passed, passed)) * root;
  float path = 2.0e-9f * film * min(thickness, 1e5f) * inside;  // light does not interfere beyond 0.1 mm
  for (uint m = 1u; m <= kFilmOrders; ++m) {
    float times = float(m);
    sum = sum + order * filmSensitivity(path * times, shift * times) * 2.0f;
    order = order * root;
  }
  vec3 none = schlick(f0, 1.0f, cosine);
  vec3 clamped = vec3(saturate(sum.x), saturate(sum.y), saturate(sum.z));
  return none + (clamped - none) * smoothstep(0.0f, 0.03f, thickness);
}

// Mean and standard deviation of the cosines between the eye and the facets of a GGX lobe that reflect uniform light to
// it, within 0.05 of the integral.
struct FacetCosines {
  float mean;
  float spread;
};
SH_FUNC FacetCosines facetCosines(float nv, float alpha) {
  FacetCosines c;
  float facing = 1.0f - 0.1f * alpha * (2.0f - alpha);
  float grazing = 0.8625f * alpha / (alpha + 0.25f);
  c.mean = sqrt(grazing * grazing * (1.0f - nv * nv) + facing * facing * nv * nv);
  c.spread = (0.06f + 0.25f * (1.0f - nv)) * alpha / (alpha + 0.08f);
  return c;
}

SH_END

#endif
