#include "shared/tonemap.h"

#include <gtest/gtest.h>

#include <limits>

#include "shared/random.h"

namespace latelight::shared {
namespace {

constexpr uint kAll[] = {kTonemapKhronosNeutral, kTonemapAces, kTonemapAgx, kTonemapReinhard, kTonemapNone};

vec3 grey(float x) {
  return vec3(x, x, x);
}
float greyOut(uint op, float x) {
  return tonemap(op, grey(x)).x;
}

TEST(Tonemap, StaysInRangeForEveryFiniteInput) {
  Random random(1);
  for (const uint op : kAll) {
    for (int i = 0; i < 20000; ++i) {
      vec3 c = vec3(random.logUniform(1e-8f, 65504.0f), random.logUniform(1e-8f, 65504.0f),
                    random.logUniform(1e-8f, 65504.0f));
      if (i % 5 == 0) c.x = 0.0f;
      if (i % 7 == 0) c.z = 0.0f;
      const vec3 t = tonemap(op, c);
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_TRUE(t[channel] >= 0.0f && t[channel] <= 1.0f) << "operator " << op;
    }
    for (const float x : {65504.0f, 1e20f, std::numeric_limits<float>::max()})
      EXPECT_TRUE(std::isfinite(greyOut(op, x)) && greyOut(op, x) > 0.9f) << "operator " << op;
  }
}

TEST(Tonemap, GrowsWithGreyAndKeepsItGrey) {
  for (const uint op : kAll) {
    EXPECT_EQ(tonemap(op, grey(0.0f)), grey(0.0f));
    float last = 0.0f;
    for (float x = 1e-6f; x < 65504.0f; x *= 1.01f) {
      const vec3 t = tonemap(op, grey(x));
      EXPECT_GE(t.x, last - 1e-6f) << "operator " << op << " at " << x;
      EXPECT_NEAR(t.x, t.y, 2e-3f);
      EXPECT_NEAR(t.x, t.z, 2e-3f);
      last = std::max(last, t.x);
    }
  }
}

// The Khronos PBR Neutral specification: with x the least channel, p the greatest after the toe, S = 0.76:
//   toe   x - (x - 6.25 x^2) = 6.25 x^2 under x = 0.08, x - 0.04 from there on (both 0.04 at 0.08)
//   1:1   in between: 0.8 comes out as 0.76, 0.5 as 0.46
//   peak  1 - 0.24^2 / (p + 0.24 - 0.76)
TEST(KhronosNeutral, HitsTheSpecificationsPoints) {
  EXPECT_NEAR(greyOut(kTonemapKhronosNeutral, 0.04f), 0.01f, 1e-6f);
  EXPECT_NEAR(greyOut(kTonemapKhronosNeutral, 0.08f), 0.04f, 1e-6f);
  EXPECT_NEAR(greyOut(kTonemapKhronosNeutral, 0.5f), 0.46f, 1e-6f);
  EXPECT_NEAR(greyOut(kTonemapKhronosNeutral, 0.8f), 0.76f, 1e-6f);
  EXPECT_NEAR(greyOut(kTonemapKhronosNeutral, 1.8f), 0.9535484f, 1e-6f);  // p 1.76: 1 - 0.0576 / 1.24
}

// A color whose smallest channel is 0 has no toe and is unchanged below the shoulder.
TEST(KhronosNeutral, LeavesSaturatedBaseColoursAlone) {
  EXPECT_EQ(tonemap(kTonemapKhronosNeutral, vec3(0.7f, 0.3f, 0.0f)), vec3(0.7f, 0.3f, 0.0f));
}

// Red of 4: new peak 1 - 0.0576 / 3.48 = 0.98344828; white share 1 - 1 / (0.15 * 3.01655172 + 1) = 0.31152360;
// green and blue get 0.98344828 * 0.31152360 = 0.3063674.
TEST(KhronosNeutral, DesaturatesWhatIsTooBright) {
  const vec3 t = tonemap(kTonemapKhronosNeutral, vec3(4.0f, 0.0f, 0.0f));
  EXPECT_NEAR(t.x, 0.98344828f, 1e-6f);
  EXPECT_NEAR(t.y, 0.3063674f, 1e-6f);
  EXPECT_EQ(t.y, t.z);
}

// The specification states the inverse in closed form (its lut-writer.mjs); tested here for gray above the shoulder.
TEST(KhronosNeutral, InvertsInClosedForm) {
  for (float x = 0.9f; x < 50.0f; x *= 1.1f) {
    const double peak = greyOut(kTonemapKhronosNeutral, x);
    EXPECT_NEAR(0.0576 / (1.0 - peak) - 0.24 + 0.76 + 0.04, x, 1e-4 * x * x);
  }
}

// Hill's curve by hand; for grey both matrices have rows that sum to 1.
//   0.18: (0.18 * 0.2045786 - 0.000090537) / (0.18 * (0.18 * 0.983729 + 0.4329510) + 0.238081)
//       = 0.036733611 / 0.347885 = 0.1055912
//   1:    1.024488063 / 1.654761 = 0.6191154
TEST(Aces, HitsHillsCurve) {
  EXPECT_NEAR(greyOut(kTonemapAces, 0.18f), 0.1055912f, 2e-6f);
  EXPECT_NEAR(greyOut(kTonemapAces, 1.0f), 0.6191154f, 1e-5f);
  EXPECT_EQ(greyOut(kTonemapAces, 1000.0f), 1.0f);
}

// AgX's own curve as its generator describes it (Sobotka 2022): through 1/2 at t = 10 / 16.5 with slope 2, and to
// either side the sigmoid x / (1 + (x / limit)^p)^(1/p), toe power 3 and shoulder power 13/4, its limit such that it
// ends at 0 and 1.
double agxExactCurve(double t) {
  const double pivot = 10.0 / 16.5, slope = 2.0;
  const double side = t < pivot ? pivot : 1.0 - pivot, power = t < pivot ? 3.0 : 13.0 / 4.0;
  const double inverseLimit = std::pow(0.5, -power) - std::pow(slope * side, -power);  // to the power
  const double x = slope * std::abs(t - pivot);
  const double y = x / std::pow(1.0 + inverseLimit * std::pow(x, power), 1.0 / power);
  return t < pivot ? 0.5 - y : 0.5 + y;
}

TEST(Agx, FollowsTheExactCurve) {
  EXPECT_NEAR(agxExactCurve(0.0), 0.0, 1e-9);
  EXPECT_NEAR(agxExactCurve(1.0), 1.0, 1e-9);
  for (double t = 0.0; t <= 1.0; t += 1.0 / 256.0) {
    const double linear = std::exp2(t * 16.5 - 12.47393);
    EXPECT_NEAR(agxCurve(float(linear)), agxExactCurve(t), 0.006) << "at " << t;
  }
}

// Middle gray is at the pivot: display code 1/2, linear 0.5^2.2 = 0.2176376.
TEST(Agx, MiddleGreyIsHalf) {
  EXPECT_NEAR(std::pow(greyOut(kTonemapAgx, 0.18f), 1.0f / 2.2f), 0.5f, 0.006f);
}

TEST(Agx, BrightColoursGoToWhite) {
  const vec3 t = tonemap(kTonemapAgx, vec3(1000.0f, 10.0f, 10.0f));
  EXPECT_GT(t.y, 0.3f);
}

TEST(Reinhard, CompressesLuminanceAndKeepsHue) {
  EXPECT_FLOAT_EQ(greyOut(kTonemapReinhard, 1.0f), 0.5f);
  EXPECT_FLOAT_EQ(greyOut(kTonemapReinhard, 3.0f), 0.75f);
  const vec3 t = tonemap(kTonemapReinhard, vec3(0.2f, 0.4f, 0.1f));
  EXPECT_FLOAT_EQ(t.y / t.x, 2.0f);
  EXPECT_FLOAT_EQ(t.x / t.z, 2.0f);
}

TEST(NoTonemap, Clips) {
  EXPECT_EQ(tonemap(kTonemapNone, vec3(0.25f, 1.5f, -1.0f)), vec3(0.25f, 1.0f, 0.0f));
}

}  // namespace
}  // namespace latelight::shared
