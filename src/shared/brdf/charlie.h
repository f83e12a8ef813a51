// Sheen of KHR_materials_sheen: the "Charlie" distribution of fibers and its visibility term (Estevez and Kulla 2017,
// Production Friendly Microfacet Sheen BRDF). All cosines are clamped to (0, 1].
#ifndef LATELIGHT_SHARED_BRDF_CHARLIE_H
#define LATELIGHT_SHARED_BRDF_CHARLIE_H

#include "shared/lang.h"

SH_BEGIN

// Minimum roughness, at which the lobe is a rim some degrees wide; at 0 the lobe would vanish.
SH_CONST float kCharlieMinRoughness = 1.0f / 16.0f;

SH_FUNC float charlieAlpha(float roughness) {
  float r = clamp(roughness, kCharlieMinRoughness, 1.0f);
  return r * r;
}

// 1/sr, an exponentiated sine, normalized so that its integral times n.h over the hemisphere is 1. `sin2` is |n x h|^2.
SH_FUNC float charlieDistribution(float sin2, float alpha) {
  float inverse = 1.0f / alpha;
  return (2.0f + inverse) * pow(max(sin2, 1e-12f), 0.5f * inverse) * (0.5f * kInvPi);
}

// Smith's lambda of that distribution, from the paper's fit to its logarithm.
SH_FUNC float charlieLogLambda(float x, float alpha) {
  float t = (1.0f - alpha) * (1.0f - alpha);
  float a = 21.5473f + (25.3245f - 21.5473f) * t;
  float b = 3.82987f + (3.32435f - 3.82987f) * t;
  float c = 0.19823f + (0.16801f - 0.19823f) * t;
  float d = -1.97760f + (-1.27393f + 1.97760f) * t;
  float e = -4.32054f + (-4.85967f + 4.32054f) * t;
  return a / (1.0f + b * pow(max(x, 1e-6f), c)) + d * x + e;
}
SH_FUNC float charlieLambda(float cosine, float alpha) {
  if (cosine < 0.5f) return exp(charlieLogLambda(cosine, alpha));
  return exp(2.0f * charlieLogLambda(0.5f, alpha) - charlieLogLambda(1.0f - cosine, alpha));
}

// 1/sr. `eyeLambda` is charlieLambda(nv, alpha).
SH_FUNC float charlieLobe(float sin2, float nl, float nv, float alpha, float eyeLambda) {
  float visibility = 0.25f / ((1.0f + eyeLambda + charlieLambda(nl, alpha)) * nv * nl);
  return charlieDistribution(sin2, alpha) * visibility;
}

// Fraction of uniform light from all directions that the lobe reflects toward an eye at n.v (directional albedo). The
// logarithm is a polynomial in the cube root of n.v and 1 / (roughness + 0.1), fitted to the integral. Its error is at
// most 0.042, and 0.0043 in the mean (relative where the albedo is above 1). The paper's visibility term creates energy
// at grazing views of small roughness: the albedo exceeds 1 for roughness below 0.26, and reaches 3.1 at the minimum
// roughness and n.v of 0.004.
SH_FUNC float charlieAlbedo(float nv, float roughness) {
  float x = pow(max(nv, 1e-6f), 1.0f / 3.0f);
  float y = 1.0f / (clamp(roughness, kCharlieMinRoughness, 1.0f) + 0.1f);
  float c0 = 1.074441f + y * (-2.269512f + y * (1.011151f + y * (-0.1613005f + y * 0.008854083f)));
  float c1 = -2.532515f + y * (8.661032f + y * (-3.434892f + y * (0.5031804f + y * -0.01848248f)));
  float c2 = 8.86807f + y * (-28.91905f + y * (9.778816f + y * (-1.070922f + y * -0.009660652f)));
  float c3 = -16.32512f + y * (38.87584f + y * (-10.41973f + y * (0.1731341f + y * 0.1713225f)));
  float c4 = 6.715985f + y * (-13.35436f + y * (-0.6435066f + y * (1.646348f + y * -0.2707212f)));
  return exp(c0 + x * (c1 + x * (c2 + x * (c3 + x * c4))));
}

// Number of directions over the hemisphere, of equal solid angle, in which the environment is sampled for the lobe.
SH_CONST uint kSheenSamples = 24u;
SH_CONST float kSheenSolidAngle = 2.0f * kPi / 24.0f;

// The i-th of these directions and the lobe's weight for its light, up to a constant factor. `along` is the eye's
// direction in the plane of the normal (unit). Roughness below kMin is clamped to it: such a lobe would be narrower
// than the spacing of the directions.
struct SheenSample {
  vec3 toLight;
  float weight;
};
SH_FUNC SheenSample sheenSample(vec3 normal, vec3 along, vec3 toEye, float nv, float roughness, uint i) {
  const float kMin = 0.2f;
  float alpha = charlieAlpha(max(roughness, kMin));
  float nl = (float(i) + 0.5f) / float(kSheenSamples);
  float sine = sqrt(1.0f - nl * nl);
  float turn = 2.0f * kPi * fract(float(i) * 0.61803399f + 0.5f);
  SheenSample r;
  r.toLight = normal * nl + along * (sine * cos(turn)) + cross(normal, along) * (sine * sin(turn));
  vec3 sum = r.toLight + toEye;
  vec3 across = cross(normal, sum * inversesqrt(max(dot(sum, sum), 1e-12f)));
  float shadowing = 1.0f + charlieLambda(nv, alpha) + charlieLambda(nl, alpha);
  r.weight = charlieDistribution(dot(across, across), alpha) / shadowing;
  return r;
}

SH_END

#endif
