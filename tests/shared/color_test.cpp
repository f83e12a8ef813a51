#include "shared/color.h"

#include <gtest/gtest.h>

#include <cmath>

namespace latelight::shared {
namespace {

TEST(Color, EverySrgbCodeSurvivesTheRoundTrip) {
  for (int code = 0; code < 256; ++code) {
    const float linear = linearFromSrgb(static_cast<float>(code) / 255.0f);
    EXPECT_NEAR(srgbFromLinear(linear) * 255.0f, static_cast<float>(code), 1e-4f);
  }
}

// IEC 61966-2-1: both ends, the join of the segments, and middle grey: ((0.5 + 0.055) / 1.055)^2.4 = 0.526066^2.4
// = exp(2.4 * -0.642328) = 0.2140411.
TEST(Color, TransferFunctionsHitTheStandardsPoints) {
  EXPECT_EQ(srgbFromLinear(0.0f), 0.0f);
  EXPECT_EQ(linearFromSrgb(0.0f), 0.0f);
  EXPECT_NEAR(srgbFromLinear(1.0f), 1.0f, 1e-6f);
  EXPECT_NEAR(linearFromSrgb(1.0f), 1.0f, 1e-6f);
  EXPECT_NEAR(linearFromSrgb(0.5f), 0.2140411f, 1e-6f);
  EXPECT_NEAR(srgbFromLinear(0.2140411f), 0.5f, 1e-6f);
  EXPECT_NEAR(linearFromSrgb(0.04045f), 0.0031308f, 1e-7f);
  EXPECT_NEAR(srgbFromLinear(0.0031308f), 0.04045f, 1e-6f);
  EXPECT_FLOAT_EQ(srgbFromLinear(0.001f), 0.01292f);
}

// IEC 61966-2-1 in double precision.
TEST(Color, EveryByteIsDecoded) {
  for (int byte = 0; byte < 256; ++byte) {
    const double x = byte / 255.0, exact = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(linearFromByte(static_cast<float>(byte) / 255.0f), exact, 7e-7 * exact) << byte;
  }
  EXPECT_EQ(linearFromByte(0.0f), 0.0f);
  EXPECT_EQ(linearFromByte(1.0f), 1.0f);
}

TEST(Color, TransferFunctionsGrowAcrossTheJoin) {
  for (float x = 0.0f; x < 1.0f; x += 1.0f / 65536.0f)
    EXPECT_GT(srgbFromLinear(x + 1.0f / 65536.0f), srgbFromLinear(x));
  // The standard's two constants disagree by 3e-8 at the join, which is below the spacing of two floats of that size.
  EXPECT_NEAR(srgbFromLinear(std::nextafter(0.0031308f, 1.0f)), srgbFromLinear(0.0031308f), 1e-7f);
}

TEST(Color, LuminanceWeighsTheRec709Primaries) {
  EXPECT_FLOAT_EQ(luminance(vec3(1.0f, 1.0f, 1.0f)), 1.0f);
  EXPECT_FLOAT_EQ(luminance(vec3(0.0f, 2.0f, 0.0f)), 1.4304f);
  EXPECT_FLOAT_EQ(luminance(vec3(1.0f, 0.0f, 10.0f)), 0.9346f);
  EXPECT_EQ(maxChannel(vec3(1.0f, 3.0f, 2.0f)), 3.0f);
}

}  // namespace
}  // namespace latelight::shared
