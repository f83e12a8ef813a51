// Normalized Blinn-Phong (Blinn 1977) with a specular color and exponent.
#ifndef LATELIGHT_SHARED_BRDF_BLINN_PHONG_H
#define LATELIGHT_SHARED_BRDF_BLINN_PHONG_H

#include "shared/brdf/ggx.h"
#include "shared/lang.h"

SH_BEGIN

// The exponent whose lobe is as wide as the GGX or Beckmann lobe of that alpha: 2 / alpha^2 - 2 (Walter et al. 2007,
// section 5.2). It ranges from 0 at roughness 1 to 2.1e6 at the smallest alpha.
SH_FUNC float exponentFromRoughness(float roughness) {
  float alpha = ggxAlpha(roughness);
  return 2.0f / (alpha * alpha) - 2.0f;
}

// The inverse, for exponents >= 0.
SH_FUNC float roughnessFromExponent(float exponent) {
  return sqrt(sqrt(2.0f / (exponent + 2.0f)));
}

// log2 of a cosine in (0, 1] whose squared sine is `sin2`. Near 1, where the cosine has lost precision, it is computed
// from the sine.
SH_FUNC float log2Cosine(float cosine, float sin2) {
  if (sin2 < 0.01f) return -0.72134752f * sin2 * (1.0f + sin2 * (0.5f + sin2 * (1.0f / 3.0f)));
  return log2(cosine);
}

// The scale of the lobe (n.h)^exponent, with which a white lobe reflects all light at normal incidence and less
// elsewhere: (n + 2)(n + 4) / (8 pi (2^(-n/2) + n)). It is exact, whereas the common (n + 8) / (8 pi) reflects up to
// 1.075 (Giesen 2009, Phong and Blinn-Phong normalization factors).
SH_FUNC float blinnPhongScale(float exponent) {
  return (exponent + 2.0f) * (exponent + 4.0f) / (exp2(-0.5f * exponent) + exponent) * (0.125f * kInvPi);
}

// 1/sr. `nh` is n.h and `sin2` is |n x h|^2; without the latter, large exponents would amplify the rounding of n.h.
SH_FUNC float blinnPhong(float nh, float sin2, float exponent, float scale) {
  if (nh <= 0.0f) return 0.0f;
  return scale * exp2(exponent * log2Cosine(nh, sin2));
}

SH_END

#endif
