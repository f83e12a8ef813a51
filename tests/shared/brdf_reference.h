// A reference implementation of the glTF 2.0 metallic-roughness BRDF, written from appendix B's formulas in double
// precision, and a quadrature over the hemisphere. It shares no code with src/shared.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/surface.h"

namespace latelight::reference {

using Vec = std::array<double, 3>;

inline Vec vec(const shared::vec3& v) {
  return {v.x, v.y, v.z};
}
inline double dot(const Vec& a, const Vec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec unit(const Vec& a) {
  const double l = std::sqrt(dot(a, a));
  return {a[0] / l, a[1] / l, a[2] / l};
}

inline double ggxDistribution(double nh, double alpha) {
  const double q = nh * nh * (alpha * alpha - 1.0) + 1.0;
  return nh > 0.0 ? alpha * alpha / (M_PI * q * q) : 0.0;
}

// Smith's lambda: G1 is 1 / (1 + lambda), and the height-correlated G2 1 / (1 + lambda(l) + lambda(v)).
inline double smithLambda(double cosine, double alpha) {
  return 0.5 * (std::sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0);
}

// mix(dielectric_brdf, metal_brdf, metallic), including KHR_materials_specular's dielectric_brdf. Requires n.l and n.v
// > 0.
inline Vec gltfBrdf(const shared::Surface& s, const Vec& n, const Vec& l, const Vec& v) {
  const Vec h = unit({l[0] + v[0], l[1] + v[1], l[2] + v[2]});
  const double alpha = double(s.roughness) * s.roughness;
  const double nl = dot(n, l), nv = dot(n, v);
  const double specular =
      ggxDistribution(dot(n, h), alpha) / (1.0 + smithLambda(nl, alpha) + smithLambda(nv, alpha)) / (4.0 * nl * nv);
  const double weight = std::pow(1.0 - std::abs(dot(v, h)), 5.0);
  Vec dielectricFresnel, result;
  for (int i = 0; i < 3; ++i) dielectricFresnel[i] = s.f0[i] + (s.f90 - s.f0[i]) * weight;
  const double most = *std::max_element(dielectricFresnel.begin(), dielectricFresnel.end());
  for (int i = 0; i < 3; ++i) {
    const double dielectric = dielectricFresnel[i] * specular + (1.0 - most) * s.baseColor[i] / M_PI;
    const double metal = (s.baseColor[i] + (1.0 - s.baseColor[i]) * weight) * specular;
    result[i] = (1.0 - s.metallic) * dielectric + s.metallic * metal;
  }
  return result;
}

// The integral over the hemisphere about Z of `f(l)`, where l is a unit Vec, with the midpoint rule in (cos, azimuth).
// The lobes must not be narrower than the cells.
template <typename F>
double integrateHemisphere(int cells, F f) {
  double sum = 0.0;
  for (int i = 0; i < cells; ++i) {
    const double z = (i + 0.5) / cells, r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < 2 * cells; ++j) {
      const double angle = M_PI * (j + 0.5) / cells;
      sum += f(Vec{r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  return sum * M_PI / (double(cells) * cells);
}

// The integral over light directions of `f(l)`, with half vectors distributed by GGX's own distribution (density D n.h
// / (4 v.h)), so that the narrowest lobe is covered as well as the widest. n is Z.
template <typename F>
double integrateLobe(int cells, const Vec& v, double alpha, F f) {
  double sum = 0.0;
  for (int i = 0; i < cells; ++i) {
    const double u = (i + 0.5) / cells;
    const double z = std::sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)), r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < cells; ++j) {
      const double angle = 2.0 * M_PI * (j + 0.5) / cells;
      const Vec h{r * std::cos(angle), r * std::sin(angle), z};
      const double vh = dot(v, h);
      const Vec l{2.0 * vh * h[0] - v[0], 2.0 * vh * h[1] - v[1], 2.0 * vh * h[2] - v[2]};
      if (vh <= 0.0 || l[2] <= 0.0) continue;
      sum += f(l) * 4.0 * vh / (ggxDistribution(z, alpha) * z);
    }
  }
  return sum / (double(cells) * cells);
}

}  // namespace latelight::reference
