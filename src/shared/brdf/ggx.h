// GGX (Trowbridge-Reitz) microfacet reflection: D, V and F of the glTF 2.0 specification, appendix B. All cosines are
// clamped to (0, 1].
#ifndef LATELIGHT_SHARED_BRDF_GGX_H
#define LATELIGHT_SHARED_BRDF_GGX_H

#include "shared/lang.h"

SH_BEGIN

// Minimum alpha: perceptual roughness 1/32. A punctual light has no size, so a smoother lobe would be a highlight
// smaller than a pixel. With D's peak at 1 / (pi alpha^2) = 3.3e5, rounding errors of unit float vectors (1e-7) stay
// below 1e-3 of the lobe.
SH_CONST float kGgxMinAlpha = 1.0f / 1024.0f;

// alpha of a perceptual roughness (Burley 2012, Physically-Based Shading at Disney).
SH_FUNC float ggxAlpha(float roughness) {
  return max(roughness * roughness, kGgxMinAlpha);
}

// Angles of the half vector h between the directions to a light and to the eye, about a normal; all vectors are unit
// length. Light from exactly opposite the eye has no half vector; its n.h is 0, so there is no highlight.
struct HalfAngles {
  float nh;    // n.h, not clamped
  float sin2;  // |n x h|^2
  float vh;    // v.h
};
// The sine is computed from a triangle whose third side is h - n, because n.h loses precision near 1.
SH_FUNC HalfAngles halfAngles(vec3 normal, vec3 toLight, vec3 toEye) {
  const float kOpposite = 1e-12f;
  vec3 sum = toLight + toEye;
  float squared = dot(sum, sum);
  float inverse = inversesqrt(max(squared, kOpposite));
  vec3 side = sum * inverse - normal;
  float side2 = dot(side, side);
  HalfAngles a;
  a.nh = squared > kOpposite ? 1.0f - 0.5f * side2 : 0.0f;
  a.sin2 = side2 * (1.0f - 0.25f * side2);
  a.vh = 0.5f * squared * inverse;
  return a;
}

// The Trowbridge-Reitz distribution (Walter et al. 2007, equation 33) is alpha^2 / (pi d^2) with this d. `nh` is n.h,
// `sin2` is |n x h|^2 and `a2` is alpha^2. The usual form 1 + (n.h)^2 (a2 - 1) loses all precision in float32 near n.h
// = 1, which is where a smooth lobe lies.
SH_FUNC float ggxDenominator(float nh, float sin2, float a2) {
  return nh * nh * a2 + sin2;
}

// 1/sr. 0 if the half vector is below the surface.
SH_FUNC float ggxDistribution(float nh, float sin2, float alpha) {
  if (nh <= 0.0f) return 0.0f;
  float a2 = alpha * alpha;
  float d = ggxDenominator(nh, sin2, a2);
  return a2 * kInvPi / (d * d);
}

// Smith masking and shadowing, height-correlated (Heitz 2014, equation 99), divided by 4 n.l n.v, is 1 / (2 (n.v
// root(n.l) + n.l root(n.v))). Appendix B names this form as the more accurate one. The energy that it loses is exactly
// the energy of multiple scattering: a random walk over the facets of Smith's surface produces the same numbers.
SH_FUNC float smithRoot(float cosine, float a2) {
  return sqrt(a2 + (1.0f - a2) * cosine * cosine);
}
SH_FUNC float ggxVisibility(float nl, float nv, float alpha) {
  float a2 = alpha * alpha;
  return 0.5f / (nv * smithRoot(nl, a2) + nl * smithRoot(nv, a2));
}

// Product of distribution and visibility with one division, because division throughput is low on GPUs. `eyeRoot` is
// smithRoot(nv, a2). `nl` may be 0.
SH_FUNC float ggxLobe(HalfAngles a, float nl, float nv, float a2, float eyeRoot) {
  float d = ggxDenominator(a.nh, a.sin2, a2);
  float lobe = a2 * (0.5f * kInvPi) * (1.0f / (d * d * (nv * smithRoot(nl, a2) + nl * eyeRoot)));
  return a.nh > 0.0f ? lobe : 0.0f;
}

// Schlick 1994: weight of the reflectance at grazing incidence, for v.h.
SH_FUNC float schlickWeight(float vh) {
  float x = saturate(1.0f - vh);
  float x2 = x * x;
  return x2 * x2 * x;
}

// Reflectance between f0 at normal and f90 at grazing incidence.
SH_FUNC vec3 schlick(vec3 f0, float f90, float vh) {
  return f0 + (vec3(f90, f90, f90) - f0) * schlickWeight(vh);
}

SH_END

#endif
