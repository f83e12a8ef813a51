// Reflectance of a thin film over a surface, of KHR_materials_iridescence: interference of the light that the film's
// two sides reflect, integrated over the spectrum (Belcour and Barla 2017, A Practical Extension to Microfacet Theory
// for the Modeling of Varying Iridescence), in the specification's form: Schlick's reflectances without polarization,
// and the first two orders of the series.
#ifndef LATELIGHT_SHARED_BRDF_THIN_FILM_H
#define LATELIGHT_SHARED_BRDF_THIN_FILM_H

#include "shared/brdf/ggx.h"

SH_BEGIN

// Reflectance at normal incidence between two indices of refraction.
SH_FUNC float reflectanceFromIors(float a, float b) {
  float r = (a - b) / (a + b);
  return r * r;
}

// The index of refraction, beside air, of a reflectance at normal incidence. Of 0.9999 it is 4e4.
SH_FUNC float iorFromReflectance(float f0) {
  float root = sqrt(min(f0, 0.9999f));
  return (1.0f + root) / (1.0f - root);
}

// Linear Rec.709 of light of which cos(2 pi path / wavelength + shift) is reflected: Fourier transforms of Gaussians
// fitted to the colour matching functions (the paper's section 4). `path` in metres; a shift each for X, Y and Z.
SH_FUNC vec3 filmSensitivity(float path, vec3 shift) {
  float phase = 2.0f * kPi * path;
  float p2 = phase * phase;
  float x = 0.8465900f * cos(1.6810e6f * phase + shift.x) * exp(-4.3278e9f * p2) +
            0.1538683f * cos(2.2399e6f * phase + shift.x) * exp(-4.5282e9f * p2);
  float y = 1.0002219f * cos(1.7953e6f * phase + shift.y) * exp(-9.3046e9f * p2);
  float z = 1.0011225f * cos(2.2084e6f * phase + shift.z) * exp(-6.6121e9f * p2);
  return vec3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z, -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
              0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
}

// What a film does to one channel of the surface beneath, whose reflectance beside air is f0.
struct FilmChannel {
  float inner;  // reflectance between film and surface
  float shift;  // of the phase where light is reflected there
};
SH_FUNC FilmChannel filmChannel(float f0, float filmIor, float innerWeight) {
  FilmChannel c;
  float base = iorFromReflectance(f0 + 0.0001f);
  float r = reflectanceFromIors(base, filmIor);
  c.inner = r + (1.0f - r) * innerWeight;
  c.shift = base < filmIor ? kPi : 0.0f;
  return c;
}

// Reflectance of a film of that thickness (nm) over a surface of reflectance f0 beside air, for light that meets it
// from air at `cosine`. Colours outside of Rec.709 are clamped, so that no channel reflects more than it receives. A
// film thinner than 0.03 nm fades out, as there is no order 0 of the series without it.
SH_FUNC vec3 thinFilm(vec3 f0, float ior, float thickness, float cosine) {
  float film = 1.0f + (max(ior, 1.0f) - 1.0f) * smoothstep(0.0f, 0.03f, thickness);
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
  vec3 both = vec3(clamp(outer * inner.x, 1e-5f, 0.9999f), clamp(outer * inner.y, 1e-5f, 0.9999f),
                   clamp(outer * inner.z, 1e-5f, 0.9999f));
  vec3 root = vec3(sqrt(both.x), sqrt(both.y), sqrt(both.z));
  vec3 series = inner * (passed * passed) / (vec3(1.0f, 1.0f, 1.0f) - both);
  vec3 sum = series + vec3(outer, outer, outer);
  vec3 order = (series - vec3(passed, passed, passed)) * root;
  float path = 2.0e-9f * film * thickness * inside;
  sum = sum + order * filmSensitivity(path, shift) * 2.0f;
  sum = sum + order * root * filmSensitivity(2.0f * path, shift * 2.0f) * 2.0f;
  return vec3(saturate(sum.x), saturate(sum.y), saturate(sum.z));
}

SH_END

#endif
