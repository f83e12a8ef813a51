// A reference implementation of glTF's layered materials, written from the KHR_materials_* specifications' formulas in
// double precision, and the spectral integral of a thin film. It shares only the structs with src/shared.
#pragma once

#include <complex>

#include "shared/brdf_reference.h"
#include "shared/layers.h"

namespace latelight::reference {

inline Vec operator+(const Vec& a, const Vec& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec operator*(const Vec& a, double s) {
  return {a[0] * s, a[1] * s, a[2] * s};
}
inline Vec halfway(const Vec& a, const Vec& b) {
  return unit(a + b);
}
inline Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// KHR_materials_sheen.
inline double charlieDistribution(double nh, double alpha) {
  return (2.0 + 1.0 / alpha) * std::pow(1.0 - nh * nh, 0.5 / alpha) / (2.0 * M_PI);
}
inline double charlieL(double x, double alpha) {
  const double t = (1.0 - alpha) * (1.0 - alpha);
  const auto at = [&](double rough, double smooth) { return rough + (smooth - rough) * t; };
  return at(21.5473, 25.3245) / (1.0 + at(3.82987, 3.32435) * std::pow(x, at(0.19823, 0.16801))) +
         at(-1.97760, -1.27393) * x + at(-4.32054, -4.85967);
}
inline double charlieLambda(double cosine, double alpha) {
  if (cosine < 0.5) return std::exp(charlieL(cosine, alpha));
  return std::exp(2.0 * charlieL(0.5, alpha) - charlieL(1.0 - cosine, alpha));
}
inline double charlie(const Vec& n, const Vec& l, const Vec& v, double alpha) {
  const double nl = dot(n, l), nv = dot(n, v);
  return charlieDistribution(dot(n, halfway(l, v)), alpha) /
         (1.0 + charlieLambda(nv, alpha) + charlieLambda(nl, alpha)) / (4.0 * nv * nl);
}

// KHR_materials_anisotropy: D and V with widths `at` along t and `ab` along b.
inline double anisotropicDistribution(const Vec& n, const Vec& t, const Vec& h, double at, double ab) {
  const Vec b = cross(n, t);
  const double a2 = at * ab;
  const Vec f{ab * dot(t, h), at * dot(b, h), a2 * dot(n, h)};
  const double w2 = a2 / dot(f, f);
  return a2 * w2 * w2 / M_PI;
}
inline double anisotropicRoot(const Vec& n, const Vec& t, const Vec& d, double at, double ab) {
  const Vec b = cross(n, t);
  return std::hypot(at * dot(t, d), ab * dot(b, d), dot(n, d));
}

inline double schlickWeight(double cosine) {
  return std::pow(std::clamp(1.0 - cosine, 0.0, 1.0), 5.0);
}

// The CIE 1931 color matching functions (Wyman, Sloan and Shirley 2013, Simple Analytic Approximations to the CIE XYZ
// Color Matching Functions, multi-lobe form); in nm.
inline Vec colorMatching(double nm) {
  const auto g = [&](double middle, double below, double above) {
    const double x = (nm - middle) / (nm < middle ? below : above);
    return std::exp(-0.5 * x * x);
  };
  return {1.056 * g(599.8, 37.9, 31.0) + 0.362 * g(442.0, 16.0, 26.7) - 0.065 * g(501.1, 20.4, 26.2),
          0.821 * g(568.8, 46.9, 40.5) + 0.286 * g(530.9, 16.3, 31.1),
          1.217 * g(437.0, 11.8, 36.0) + 0.681 * g(459.0, 26.0, 13.8)};
}

// CIE standard illuminant D65, every 10 nm from 380 nm on.
inline double daylight(double nm) {
  static constexpr double kPower[] = {
      49.98,  54.65,  82.75,  91.49,  93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80,
      104.79, 107.69, 104.41, 104.05, 100.0, 96.33, 95.79,  88.69,  90.01,  89.60,  87.70,  83.29,  83.70,  80.03,
      80.21,  82.28,  78.28,  69.72,  71.61, 74.35, 61.60,  69.89,  75.09,  63.59,  46.42,  66.81,  63.38,  63.38};
  const double place = (nm - 380.0) / 10.0;
  const auto i = static_cast<size_t>(place);
  return kPower[i] + (kPower[i + 1] - kPower[i]) * (place - static_cast<double>(i));
}

inline Vec rec709(const Vec& xyz) {
  return {3.2404542 * xyz[0] - 1.5371385 * xyz[1] - 0.4985314 * xyz[2],
          -0.9692660 * xyz[0] + 1.8760108 * xyz[1] + 0.0415560 * xyz[2],
          0.0556434 * xyz[0] - 0.2040259 * xyz[1] + 1.0572252 * xyz[2]};
}

// Airy's sum over all orders of reflection in the film at one wavelength, with the interfaces of
// KHR_materials_iridescence.
inline double airy(double f0, double ior, double thickness, double cosine, double nm) {
  const double root = std::sqrt(std::min(f0, 0.9999)), base = (1.0 + root) / (1.0 - root);
  const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
  const auto reflects = [](double a, double b, double c) {
    const double r = (a - b) * (a - b) / ((a + b) * (a + b));
    return r + (1.0 - r) * schlickWeight(c);
  };
  const double r12 = reflects(ior, 1.0, cosine), r23 = reflects(base, ior, inside);
  const double phase = 4.0 * M_PI * ior * thickness * inside / nm + M_PI + (base < ior ? M_PI : 0.0);
  const double amplitude = std::sqrt(r12 * r23);
  const std::complex<double> z = std::polar(amplitude, phase);
  const double passes = (1.0 - r12) * (1.0 - r12) * r23 / (1.0 - r12 * r23);
  return r12 + passes + 2.0 * (passes - (1.0 - r12)) * (z / (1.0 - z)).real();
}

// Its color in daylight, which is white.
inline Vec filmColor(double f0, double ior, double thickness, double cosine) {
  Vec sum{}, white{};
  for (double nm = 380.5; nm < 780.0; nm += 1.0) {
    const Vec seen = rec709(colorMatching(nm)) * daylight(nm);
    sum = sum + seen * airy(f0, ior, thickness, cosine, nm);
    white = white + seen;
  }
  for (int c = 0; c < 3; ++c) sum[c] = std::clamp(sum[c] / white[c], 0.0, 1.0);
  return sum;
}

// Trowbridge-Reitz's D and Smith's V.
inline double ggx(const Vec& n, const Vec& l, const Vec& v, double alpha) {
  const double nl = dot(n, l), nv = dot(n, v);
  return ggxDistribution(dot(n, halfway(l, v)), alpha) / (1.0 + smithLambda(nl, alpha) + smithLambda(nv, alpha)) /
         (4.0 * nl * nv);
}

// All layers except film and volume, for light from either side, times |n.l|. `sheenAlbedo` is E(n.v).
inline Vec layeredRadiance(const shared::Surface& s, const shared::SurfaceLayers& a, const Vec& l, const Vec& v,
                           double sheenAlbedo) {
  const Vec n = unit(vec(s.normal)), t = unit(vec(a.anisotropyDirection)), coat = unit(vec(a.clearcoatNormal));
  const double nl = dot(n, l), nv = dot(n, v), alpha = double(s.roughness) * s.roughness;
  const Vec mirrored = nl > 0.0 ? l : l + n * (-2.0 * nl);
  const Vec h = halfway(mirrored, v);
  const double weight = schlickWeight(dot(v, h)), along = alpha + (1.0 - alpha) * a.anisotropy * a.anisotropy;
  const double lobe = anisotropicDistribution(n, t, h, along, alpha) * 0.5 /
                      (nv * anisotropicRoot(n, t, l, along, alpha) + nl * anisotropicRoot(n, t, v, along, alpha));
  double most = 0.0;
  for (int c = 0; c < 3; ++c) most = std::max(most, s.f0[c] + (s.f90 - s.f0[c]) * weight);
  const double alphaThrough = std::pow(s.roughness * std::clamp(2.0 * a.ior - 2.0, 0.0, 1.0), 2.0);
  const double coatReflects = a.clearcoat * (0.04 + 0.96 * schlickWeight(dot(coat, v)));
  const double mostSheen = std::max({a.sheenColor.x, a.sheenColor.y, a.sheenColor.z});
  const double sheenAlpha = std::pow(a.sheenRoughness, 2.0), coatAlpha = std::pow(a.clearcoatRoughness, 2.0);
  Vec sum{};
  for (int c = 0; c < 3; ++c) {
    const double diffuse = (1.0 - most) / M_PI;
    double dielectric = (s.f0[c] + (s.f90 - s.f0[c]) * weight) * lobe;
    dielectric += diffuse * (1.0 - a.transmission) * (1.0 - a.diffuseTransmission) * s.baseColor[c];
    double metal = (s.baseColor[c] + (1.0 - s.baseColor[c]) * weight) * lobe;
    double sheen = nl > 0.0 && mostSheen > 0.0 ? a.sheenColor[c] * charlie(n, l, v, sheenAlpha) : 0.0;
    if (nl < 0.0) {
      metal = 0.0;
      dielectric = diffuse * (1.0 - a.transmission) * a.diffuseTransmission * a.diffuseTransmissionColor[c] +
                   (1.0 - most) * a.transmission * s.baseColor[c] * ggx(n, mirrored, v, alphaThrough);
    }
    sum[c] = (dielectric * (1.0 - s.metallic) + metal * s.metallic) * (1.0 - mostSheen * sheenAlbedo) + sheen;
    sum[c] *= std::abs(nl) * (1.0 - coatReflects);
    if (dot(coat, l) > 0.0) sum[c] += coatReflects * ggx(coat, l, v, coatAlpha) * dot(coat, l);
  }
  return sum;
}

}  // namespace latelight::reference
