// Punctual light on a surface: numeric values of glTF 2.0 appendix B, and the laws that every BRDF obeys.
#include <gtest/gtest.h>

#include "shared/brdf_reference.h"
#include "shared/random.h"
#include "shared/shade.h"

namespace latelight::shared {
namespace {

using reference::Vec;

const vec3 kUp(0.0f, 0.0f, 1.0f);

Surface surface(vec3 baseColor, float metallic, float roughness) {
  Surface s = emptySurface();
  s.baseColor = baseColor;
  s.metallic = metallic;
  s.roughness = roughness;
  s.f0 = vec3(0.04f, 0.04f, 0.04f);
  s.f90 = 1.0f;
  return s;
}

Surface randomSurface(Random& random) {
  Surface s = surface(random.color(), std::round(random.uniform(0.0f, 2.0f)) * 0.5f, random.uniform(0.05f, 1.0f));
  s.normal = random.direction();
  if (random.uniform() < 0.5f) {  // KHR_materials_specular and _ior
    s.f90 = random.uniform();
    s.f0 = random.color() * s.f90;
  }
  return s;
}

// Irradiance of pi, which cancels the 1/pi in every term.
vec3 litByPi(Surface s, vec3 toLight, vec3 toEye, uint shading = kShadingGgx) {
  return shadeLight(surfaceBrdf(s, toEye, shading), LightSample{toLight, vec3(kPi, kPi, kPi), 1.0f}, shading);
}

void expectRadiance(vec3 actual, double r, double g, double b) {
  EXPECT_NEAR(actual.x, r, 2e-6);
  EXPECT_NEAR(actual.y, g, 2e-6);
  EXPECT_NEAR(actual.z, b, 2e-6);
}

// --- by hand
// ---------------------------------------------------------------------------------------------------------- With an
// irradiance of pi: L = n.l (pi f_diffuse + F pi D V).

// Light and eye along the normal, alpha 1. All cosines are 1, the Schlick weight 0, F = 0.04.
// pi D = 1 / (1 (1 - 1) + 1)^2 = 1.  V = 0.5 / (1 + 1) = 1/4.
// L = 0.96 * 0.5 + 0.04 / 4 = 0.49.
TEST(GgxByHand, RoughDielectricFromAbove) {
  expectRadiance(litByPi(surface(vec3(0.5f, 0.5f, 0.5f), 0.0f, 1.0f), kUp, kUp), 0.49, 0.49, 0.49);
}

// The same for a metal of roughness 1/2, alpha 1/4: pi D = (1/16) / (1/16)^2 = 16, V = 1/4 (the root is 1 for every
// alpha at n.l = 1). L = 4 base colour.
TEST(GgxByHand, MetalFromAbove) {
  expectRadiance(litByPi(surface(vec3(1.0f, 0.5f, 0.25f), 1.0f, 0.5f), kUp, kUp), 4.0, 2.0, 1.0);
}

// Light and eye 60 degrees to either side, h = n, alpha 1/2 (roughness sqrt(1/2)):
// n.l = n.v = v.h = 1/2, n.h = 1.   Schlick weight (1/2)^5 = 1/32, F = 0.04 + 0.96 / 32 = 0.07.
// pi D = (1/4) / (1/4)^2 = 4.       root: sqrt(1/4 + 3/4 * 1/4) = sqrt(0.4375) = 0.66143783
// V = 0.5 / (0.5 * 0.66143783 + 0.5 * 0.66143783) = 0.75592895
// specular 0.07 * 4 * 0.75592895 / 2 = 0.10583005;  diffuse 0.93 * 0.8 / 2 = 0.372.
TEST(GgxByHand, MirrorDirectionAtSixtyDegrees) {
  const float sine = std::sqrt(0.75f);
  const vec3 light(sine, 0.0f, 0.5f), eye(-sine, 0.0f, 0.5f);
  const vec3 l = litByPi(surface(vec3(0.8f, 0.4f, 0.0f), 0.0f, std::sqrt(0.5f)), light, eye);
  expectRadiance(l, 0.372 + 0.10583005, 0.186 + 0.10583005, 0.10583005);
}

// Light and eye together at 60 degrees, h = l = v, alpha 1/2, half metal: v.h = 1, so the Schlick weight is 0.
// n.h = 1/2: pi D = (1/4) / ((1/4)(-3/4) + 1)^2 = 0.25 / 0.8125^2 = 0.37869822.   V = 0.75592895 as above.
// lobe 0.37869822 * 0.75592895 / 2 = 0.14313448.   F: half of 0.04 and half of the base colour = (0.42, 0.12, 0.07).
// diffuse: half of it, 0.5 * 0.96 * (0.8, 0.2, 0.1) / 2 = (0.192, 0.048, 0.024).
TEST(GgxByHand, HalfMetalSeenFromTheLight) {
  const vec3 d(std::sqrt(0.75f), 0.0f, 0.5f);
  const vec3 l = litByPi(surface(vec3(0.8f, 0.2f, 0.1f), 0.5f, std::sqrt(0.5f)), d, d);
  expectRadiance(l, 0.192 + 0.42 * 0.14313448, 0.048 + 0.12 * 0.14313448, 0.024 + 0.07 * 0.14313448);
}

// KHR_materials_specular: from above, alpha 1, a tinted f0 of (0.5, 0.1, 0.02). Its largest channel, 0.5, is what the
// diffuse part loses in every channel: 0.5 * 0.4 = 0.2.  Specular: f0 / 4.
TEST(GgxByHand, TintedSpecularTakesItsLargestChannelFromDiffuse) {
  Surface s = surface(vec3(0.4f, 0.4f, 0.4f), 0.0f, 1.0f);
  s.f0 = vec3(0.5f, 0.1f, 0.02f);
  expectRadiance(litByPi(s, kUp, kUp), 0.2 + 0.125, 0.2 + 0.025, 0.2 + 0.005);
}

// KHR_materials_specular with a factor of 0: pure Lambert at any angle. n.l = 0.8.
TEST(GgxByHand, NoSpecularIsLambert) {
  Surface s = surface(vec3(0.5f, 0.25f, 1.0f), 0.0f, 0.3f);
  s.f0 = vec3(0.0f, 0.0f, 0.0f);
  s.f90 = 0.0f;
  expectRadiance(litByPi(s, vec3(0.6f, 0.0f, 0.8f), vec3(-0.96f, 0.0f, 0.28f)), 0.4, 0.2, 0.8);
}

// --- against appendix B in double precision
// ---------------------------------------------------------------------------

double eightBit(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return 255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055);
}

TEST(Ggx, FollowsAppendixBToFarUnderHalfAnEightBitLevel) {
  Random random(1);
  double worstLevel = 0.0, worstRelative = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const Surface s = randomSurface(random);
    const vec3 light = random.directionAbout(s.normal), eye = random.directionAbout(s.normal);
    if (dot(s.normal, eye) < kMinNv || dot(s.normal, light) < 1e-3f) continue;
    const vec3 actual = litByPi(s, light, eye);
    const Vec n = reference::unit(reference::vec(s.normal)), l = reference::unit(reference::vec(light));
    const Vec expected = reference::gltfBrdf(s, n, l, reference::unit(reference::vec(eye)));
    for (int channel = 0; channel < 3; ++channel) {
      const double radiance = expected[channel] * M_PI * reference::dot(n, l);
      worstLevel = std::max(worstLevel, std::abs(eightBit(actual[channel]) - eightBit(radiance)));
      worstRelative = std::max(worstRelative, std::abs(actual[channel] / radiance - 1.0));
    }
  }
  EXPECT_LT(worstLevel, 0.01);
  EXPECT_LT(worstRelative, 2e-4);
  RecordProperty("worst 8-bit level", std::to_string(worstLevel));
  RecordProperty("worst relative", std::to_string(worstRelative));
}

// Perceptual roughness 1/32, near the highlight, where 1 + (n.h)^2 (alpha^2 - 1) is mostly rounding error in float32.
TEST(Ggx, SmallestRoughnessKeepsItsDigitsAroundThePeak) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Surface s = surface(vec3(1.0f, 1.0f, 1.0f), 1.0f, 1.0f / 32.0f);
    const float tilt = random.uniform(0.0f, 8.0f) * kGgxMinAlpha, turn = random.uniform(0.0f, 6.28f);
    const vec3 light =
        normalize(vec3(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)));
    const Vec l = reference::unit(reference::vec(light));
    const double expected = reference::gltfBrdf(s, {0, 0, 1}, l, {0, 0, 1})[0] * M_PI * l[2];
    EXPECT_NEAR(litByPi(s, light, kUp).x / expected, 1.0, 1e-3);
  }
}

TEST(Ggx, RoughnessZeroIsTheSmallestRoughness) {
  EXPECT_EQ(ggxAlpha(0.0f), kGgxMinAlpha);
  EXPECT_EQ(ggxAlpha(0.5f), 0.25f);
  const vec3 peak = litByPi(surface(vec3(1.0f, 1.0f, 1.0f), 1.0f, 0.0f), kUp, kUp);
  EXPECT_FLOAT_EQ(peak.x, 1024.0f * 1024.0f / 4.0f);
}

TEST(Ggx, DistributionIntegratesToOneOverTheProjectedHemisphere) {
  for (const float roughness : {0.0f, 0.05f, 0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) {
    const float alpha = ggxAlpha(roughness);
    // d(solid angle) n.h = pi d(sin^2); substituting sin^2 = exp(y) resolves lobes of every width.
    const int steps = 20000;
    const double low = std::log(1e-12), dy = -low / steps;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
      const double sin2 = std::exp(low + (i + 0.5) * dy);
      sum += M_PI * ggxDistribution(float(std::sqrt(1.0 - sin2)), float(sin2), alpha) * sin2 * dy;
    }
    EXPECT_NEAR(sum, 1.0, 1e-4) << "roughness " << roughness;
  }
}

// Heitz 2014: light and eye on the same side see the same facets. More light therefore passes than for independent
// masking, but at most as much as the direction with more masking lets through.
TEST(Ggx, VisibilityIsCorrelated) {
  EXPECT_FLOAT_EQ(ggxVisibility(1.0f, 1.0f, 0.3f), 0.25f);
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const float nl = random.uniform(1e-3f, 1.0f), nv = random.uniform(1e-3f, 1.0f), alpha = random.uniform(1e-3f, 1.0f);
    const double passed = 4.0 * nl * nv * ggxVisibility(nl, nv, alpha);
    const double byLight = 1.0 / (1.0 + reference::smithLambda(nl, alpha));
    const double byEye = 1.0 / (1.0 + reference::smithLambda(nv, alpha));
    EXPECT_GE(passed, byLight * byEye * 0.99999);
    EXPECT_LE(passed, std::min(byLight, byEye) * 1.00001);
  }
}

// A white mirror of any roughness scatters at most the light that arrives, and all of it if it is smooth.
TEST(Ggx, WhiteMetalReflectsNoMoreThanItReceives) {
  for (const float roughness : {0.03125f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
    const Surface s = surface(vec3(1.0f, 1.0f, 1.0f), 1.0f, roughness);
    for (const double cosine : {1.0, 0.8, 0.5, 0.25, 0.1, 0.02}) {
      const Vec v{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
      const vec3 eye(float(v[0]), 0.0f, float(v[2]));
      const double albedo = reference::integrateLobe(200, v, ggxAlpha(roughness), [&](const Vec& l) {
        const vec3 light{float(l[0]), float(l[1]), float(l[2])};
        return shadeLight(surfaceBrdf(s, eye, kShadingGgx), LightSample{light, vec3(1.0f, 1.0f, 1.0f), 1.0f},
                          kShadingGgx)
            .x;
      });
      EXPECT_LE(albedo, 1.0005) << "roughness " << roughness << ", n.v " << cosine;
      if (roughness < 0.05f && cosine > 0.2) {
        EXPECT_GE(albedo, 0.995) << "n.v " << cosine;
      }
    }
  }
}

// Appendix B states that its coupling of diffuse and specular does not conserve energy at grazing angles. The error is
// bounded: a white dielectric returns at most 1.32 of the incoming light at n.v = 0.05, and at most all of it above
// 0.75.
TEST(Ggx, WhiteDielectricStaysWithinAppendixBsKnownExcess) {
  double worst = 0.0;
  for (const float roughness : {0.3f, 0.5f, 0.75f, 1.0f}) {
    const Surface s = surface(vec3(1.0f, 1.0f, 1.0f), 0.0f, roughness);
    for (const double cosine : {1.0, 0.75, 0.5, 0.2, 0.1, 0.05}) {
      const vec3 eye(float(std::sqrt(1.0 - cosine * cosine)), 0.0f, float(cosine));
      const double albedo = reference::integrateHemisphere(250, [&](const Vec& l) {
        const vec3 light{float(l[0]), float(l[1]), float(l[2])};
        return shadeLight(surfaceBrdf(s, eye, kShadingGgx), LightSample{light, vec3(1.0f, 1.0f, 1.0f), 1.0f},
                          kShadingGgx)
            .x;
      });
      worst = std::max(worst, albedo);
      if (cosine >= 0.75) {
        EXPECT_LE(albedo, 1.001) << "roughness " << roughness << ", n.v " << cosine;
      }
    }
  }
  EXPECT_LE(worst, 1.32);
  RecordProperty("worst albedo", std::to_string(worst));
}

TEST(Shading, IsReciprocalAndPositive) {
  Random random(4);
  for (const uint shading : {kShadingGgx, kShadingBlinnPhong, kShadingGgxCompensated}) {
    for (int i = 0; i < 20000; ++i) {
      const Surface s = randomSurface(random);
      const vec3 a = random.directionAbout(s.normal), b = random.directionAbout(s.normal);
      const float na = dot(s.normal, a), nb = dot(s.normal, b);
      if (na < 1e-3f || nb < 1e-3f) continue;
      const vec3 forth = litByPi(s, a, b, shading) * (1.0f / na), back = litByPi(s, b, a, shading) * (1.0f / nb);
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(forth[c], 0.0f);
        EXPECT_NEAR(forth[c], back[c], 1e-3f * std::max(forth[c], 1e-3f));
      }
    }
  }
}

TEST(Shading, IsBlackFromBehindAndFiniteEverywhere) {
  Random random(5);
  for (const uint shading : {kShadingGgx, kShadingBlinnPhong, kShadingGgxCompensated}) {
    for (int i = 0; i < 20000; ++i) {
      Surface s = randomSurface(random);
      if (i % 4 == 0) s.roughness = 0.0f;
      const vec3 light = random.direction();
      vec3 eye = random.direction();
      if (i % 3 == 0) eye = light * -1.0f;     // no half vector
      if (i % 3 == 1) eye = s.normal * -1.0f;  // a mapped normal turned away from the eye
      const vec3 l = litByPi(s, light, eye, shading);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(l[c]) && l[c] >= 0.0f);
      if (dot(s.normal, light) <= 0.0f) {
        EXPECT_EQ(l, vec3(0.0f, 0.0f, 0.0f));
      }
    }
  }
}

TEST(Shading, SurfaceWithoutReflectionIsBlack) {
  const Surface s = withoutReflection(surface(vec3(1.0f, 1.0f, 1.0f), 0.7f, 0.2f));
  for (const uint shading : {kShadingGgx, kShadingBlinnPhong, kShadingGgxCompensated})
    EXPECT_EQ(litByPi(s, kUp, vec3(0.6f, 0.0f, 0.8f), shading), vec3(0.0f, 0.0f, 0.0f));
  EXPECT_EQ(shadeEnvironment(s, kUp, vec3(1, 1, 1), vec3(1, 1, 1), vec2(0.5f, 0.1f)), vec3(0.0f, 0.0f, 0.0f));
}

// --- Blinn-Phong
// ------------------------------------------------------------------------------------------------------

// From above: the lobe is (n+2)(n+4) / (8 pi (2^(-n/2) + n)); for n = 6 (alpha 1/2): 80 / (8 pi 6.125) = 1.6326531 /
// pi. Diffuse: (1 - 0.04) 0.5.
TEST(BlinnPhongByHand, DielectricFromAbove) {
  const vec3 l = litByPi(surface(vec3(0.5f, 0.5f, 0.5f), 0.0f, std::sqrt(0.5f)), kUp, kUp, kShadingBlinnPhong);
  EXPECT_NEAR(l.x, 0.48 + 0.04 * 1.6326531, 2e-6);
}

// Light above, eye at 60 degrees: n.h = cos 30 = sqrt(3/4), (n.h)^6 = (3/4)^3 = 0.421875. Metal: no diffuse part.
TEST(BlinnPhongByHand, MetalAtSixtyDegrees) {
  const Surface s = surface(vec3(1.0f, 0.5f, 0.25f), 1.0f, std::sqrt(0.5f));
  const vec3 l = litByPi(s, kUp, vec3(std::sqrt(0.75f), 0.0f, 0.5f), kShadingBlinnPhong);
  expectRadiance(l, 0.6887755, 0.3443878, 0.1721939);  // 1.6326531 * 0.421875 = 0.68877551
}

TEST(BlinnPhong, ExponentAndRoughnessAreInverse) {
  EXPECT_FLOAT_EQ(exponentFromRoughness(1.0f), 0.0f);
  EXPECT_FLOAT_EQ(exponentFromRoughness(std::sqrt(0.5f)), 6.0f);
  EXPECT_FLOAT_EQ(roughnessFromExponent(0.0f), 1.0f);
  for (float roughness = 0.035f; roughness < 1.0f; roughness += 0.01f)
    EXPECT_NEAR(roughnessFromExponent(exponentFromRoughness(roughness)), roughness, 1e-6f);
}

// A white lobe reflects exactly all light that arrives along the normal, and less at every other angle.
TEST(BlinnPhong, LobeIsNormalised) {
  for (const float exponent : {0.0f, 1.0f, 4.0f, 16.0f, 255.0f}) {
    for (const double cosine : {1.0, 0.9, 0.5, 0.1}) {
      const Vec v{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
      const double albedo = reference::integrateHemisphere(800, [&](const Vec& l) {
        const Vec h = reference::unit({l[0] + v[0], l[1] + v[1], l[2] + v[2]});
        return l[2] * blinnPhong(float(h[2]), float(h[0] * h[0] + h[1] * h[1]), exponent, blinnPhongScale(exponent));
      });
      if (cosine == 1.0) {
        EXPECT_NEAR(albedo, 1.0, 1e-3) << "exponent " << exponent;
      } else {
        EXPECT_LE(albedo, 1.001) << "exponent " << exponent << ", n.v " << cosine;
      }
    }
  }
}

TEST(BlinnPhong, LargestExponentKeepsItsDigits) {
  const float exponent = exponentFromRoughness(0.0f);
  for (double tilt = 0.0; tilt < 3e-3; tilt += 1e-5) {
    const double sin2 = std::sin(tilt) * std::sin(tilt);
    const double lobe =
        (exponent + 2.0) * (exponent + 4.0) / (8.0 * M_PI * exponent) * std::pow(std::cos(tilt), exponent);
    EXPECT_NEAR(blinnPhong(float(std::cos(tilt)), float(sin2), exponent, blinnPhongScale(exponent)) / lobe, 1.0, 1e-4);
  }
}

// --- environment
// ------------------------------------------------------------------------------------------------------

// In a room of radiance 1 on all sides, white surfaces of every kind are indistinguishable from the room.
TEST(EnvironmentShading, WhiteSurfacesVanishInAWhiteRoom) {
  const vec3 one(1.0f, 1.0f, 1.0f);
  for (const vec2 table : {vec2(0.95f, 0.05f), vec2(0.6f, 0.1f), vec2(0.3f, 0.2f), vec2(1.0f, 0.0f)}) {
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
      const vec3 l = shadeEnvironment(surface(one, metallic, 0.6f), vec3(0.6f, 0.0f, 0.8f), one, one, table);
      EXPECT_NEAR(l.x, 1.0f, 1e-6f);
    }
  }
}

// Metal of 0.5 with a table of (0.6, 0.1): once 0.5 * 0.6 + 0.1 = 0.4. Mean reflectance 0.5 + 0.5 / 21 = 0.5238095;
// lost 0.3, again 0.225. More: 0.5238095^2 * 0.3 * 0.775 / (1 - 0.5238095 * 0.225) = 0.2743764 * 0.2325 / 0.8821429 =
// 0.0723152.
TEST(EnvironmentShading, MultipleScatteringByHand) {
  const Surface s = surface(vec3(0.5f, 0.5f, 0.5f), 1.0f, 0.6f);
  const vec2 table(0.6f, 0.1f);
  EXPECT_NEAR(shadeEnvironment(s, kUp, vec3(0, 0, 0), vec3(1, 1, 1), table).x, 0.4f, 1e-6f);
  EXPECT_NEAR(shadeEnvironment(s, kUp, vec3(1, 1, 1), vec3(0, 0, 0), table).x, 0.0723152f, 1e-6f);
}

// Dielectric of f0 0.04 with a smooth table (0.95, 0.01): once 0.048; mean 0.04 + 0.96 / 21 = 0.0857143; lost 0.04,
// again 0.03; more 0.0073469 * 0.04 * 0.97 / (1 - 0.0025714) = 0.00028580. Diffuse 0.5 (1 - 0.0482858) = 0.4758571.
TEST(EnvironmentShading, DiffuseGetsWhatReflectionLeaves) {
  const Surface s = surface(vec3(0.5f, 0.5f, 0.5f), 0.0f, 0.2f);
  const float l = shadeEnvironment(s, kUp, vec3(2, 2, 2), vec3(0, 0, 0), vec2(0.95f, 0.01f)).x;
  EXPECT_NEAR(l, 2.0f * (0.4758571f + 0.00028580f), 1e-6f);
}

TEST(EnvironmentShading, OcclusionDarkensBothParts) {
  Surface s = surface(vec3(0.5f, 0.5f, 0.5f), 0.0f, 0.5f);
  const vec2 table(0.9f, 0.02f);
  const vec3 one(1.0f, 1.0f, 1.0f), none(0.0f, 0.0f, 0.0f);
  const float diffuse = shadeEnvironment(s, kUp, one, none, table).x,
              specular = shadeEnvironment(s, kUp, none, one, table).x;
  s.ao = 0.5f;
  EXPECT_NEAR(shadeEnvironment(s, kUp, one, none, table).x, 0.5f * diffuse, 1e-6f);
  // Listing 26 with n.v 1, occlusion 0.5, alpha 0.25: 1.5^(2^(-5)) - 1 + 0.5 = 1.0127516 - 0.5.
  EXPECT_NEAR(shadeEnvironment(s, kUp, none, one, table).x, 0.5127516f * specular, 1e-6f);
  s.ao = 0.0f;
  EXPECT_EQ(shadeEnvironment(s, kUp, one, one, table), none);
}

}  // namespace
}  // namespace latelight::shared
