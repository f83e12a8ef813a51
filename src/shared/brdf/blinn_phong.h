// Blinn-Phong (Blinn 1977) with a specular colour and exponent, as the seeds 000 and 002 light with, normalised.
#ifndef LATELIGHT_SHARED_BRDF_BLINN_PHONG_H
#define LATELIGHT_SHARED_BRDF_BLINN_PHONG_H

#include "shared/brdf/ggx.h"
#include "shared/lang.h"

SH_BEGIN

// The exponent whose lobe is as wide as GGX's or Beckmann's of that alpha: 2 / alpha^2 - 2 (Walter et al. 2007,
// section 5.2). From 0 at roughness 1 to 2.1e6 at the smallest alpha.
SH_FUNC float exponentFromRoughness(float roughness) {
  float alpha = ggxAlpha(roughness);
  return 2.0f / (alpha * alpha) - 2.0f;
}

// The inverse, for exponents >= 0.
SH_FUNC float roughnessFromExponent(float exponent) {
  return sqrt(sqrt(2.0f / (exponent + 2.0f)));
}

// log2(1 - x) for x in [0, 1): the series where 1 - x would round x away.
SH_FUNC float log2OneMinus(float x) {
  if (x < 0.01f) return -1.44269504f * x * (1.0f + x * (0.5f + x * (1.0f / 3.0f)));
  return log2(1.0f - x);
}

// The lobe (n.h)^exponent, times what makes a white one reflect all light at normal incidence and less elsewhere:
// (n + 2)(n + 4) / (8 pi (2^(-n/2) + n)), exact, where the common (n + 8) / (8 pi) reflects up to 1.075 (Giesen 2009,
// Phong and Blinn-Phong normalization factors). 1/sr. `nh` is n.h and `sin2` |n x h|^2: (n.h)^n is computed as (1 -
// sin2)^(n/2), which keeps its digits for large exponents.
SH_FUNC float blinnPhong(float nh, float sin2, float exponent) {
  if (nh <= 0.0f || sin2 >= 1.0f) return 0.0f;
  float n2 = 0.5f * exponent;
  float scale = (exponent + 2.0f) * (exponent + 4.0f) / (exp2(-n2) + exponent) * (0.125f * kInvPi);
  return scale * exp2(n2 * log2OneMinus(sin2));
}

SH_END

#endif
