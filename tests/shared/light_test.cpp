#include "shared/light.h"

#include <gtest/gtest.h>

#include <limits>

namespace latelight::shared {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Light pointLight(vec3 position, vec3 intensity, float radius) {
  Light light{};
  light.type = kLightPoint;
  light.position = position;
  light.intensity = intensity;
  light.radius = radius;
  light.inverseRadius2 = inverseRadius2(radius);
  return light;
}

TEST(LightWindow, IsTheOneOfKhrLightsPunctual) {
  const float eight = inverseRadius2(8.0f);
  EXPECT_EQ(lightWindow(0.0f, eight), 1.0f);
  EXPECT_FLOAT_EQ(lightWindow(16.0f, eight), 0.9375f);      // 1 - (1/2)^4
  EXPECT_FLOAT_EQ(lightWindow(36.0f, eight), 0.68359375f);  // 1 - (3/4)^4
  EXPECT_EQ(lightWindow(64.0f, eight), 0.0f);
  EXPECT_EQ(lightWindow(81.0f, eight), 0.0f);
  EXPECT_EQ(lightWindow(kMaxLightDistance2, eight), 0.0f);
  EXPECT_EQ(lightWindow(kMaxLightDistance2, inverseRadius2(kInfinity)), 1.0f);
}

TEST(SampleLight, DirectionalIsTheSameEverywhere) {
  Light light{};
  light.type = kLightDirectional;
  light.direction = vec3(0.0f, 0.6f, -0.8f);
  light.intensity = vec3(3.0f, 2.0f, 1.0f);
  light.radius = kInfinity;
  const LightSample s = sampleLight(light, vec3(1e5f, -3.0f, 7.0f));
  EXPECT_EQ(s.toLight, vec3(0.0f, -0.6f, 0.8f));
  EXPECT_EQ(irradianceOf(s), light.intensity);
}

TEST(SampleLight, PointFollowsTheInverseSquare) {
  const Light light = pointLight(vec3(1.0f, 2.0f, 3.0f), vec3(8.0f, 4.0f, 2.0f), kInfinity);
  const LightSample s = sampleLight(light, vec3(1.0f, 2.0f, 1.0f));
  EXPECT_EQ(s.toLight, vec3(0.0f, 0.0f, 1.0f));
  EXPECT_EQ(irradianceOf(s), vec3(2.0f, 1.0f, 0.5f));
}

TEST(SampleLight, RangeOfFourHalvesNothingButTheWindow) {
  const Light light = pointLight(vec3(0.0f, 0.0f, 0.0f), vec3(4.0f, 4.0f, 4.0f), 4.0f);
  EXPECT_FLOAT_EQ(irradianceOf(sampleLight(light, vec3(0.0f, 2.0f, 0.0f))).x, 0.9375f);
  EXPECT_EQ(irradianceOf(sampleLight(light, vec3(0.0f, 4.0f, 0.0f))).x, 0.0f);
}

TEST(SampleLight, StaysFiniteAtTheLightItself) {
  for (const uint type : {kLightPoint, kLightSpot}) {
    Light light = pointLight(vec3(1.0f, 2.0f, 3.0f), vec3(1e5f, 1e5f, 1e5f), 10.0f);
    light.type = type;
    light.direction = vec3(0.0f, 0.0f, -1.0f);
    spotCone(0.2f, 0.4f, light.spotScale, light.spotOffset);
    const LightSample s = sampleLight(light, light.position);
    EXPECT_EQ(s.toLight, vec3(0.0f, 0.0f, 0.0f));
    EXPECT_TRUE(std::isfinite(irradianceOf(s).x));
  }
}

TEST(SampleLight, StaysFiniteFarAway) {
  const Light light = pointLight(vec3(0.0f, 0.0f, 0.0f), vec3(1e5f, 1e5f, 1e5f), 10.0f);
  EXPECT_EQ(irradianceOf(sampleLight(light, vec3(1e25f, 0.0f, 0.0f))), vec3(0.0f, 0.0f, 0.0f));
}

// One candela at one meter along a ray at `angle` from the axis.
float spotAt(float inner, float outer, float angle) {
  Light light = pointLight(vec3(0.0f, 0.0f, 0.0f), vec3(1.0f, 1.0f, 1.0f), kInfinity);
  light.type = kLightSpot;
  light.direction = vec3(0.0f, 1.0f, 0.0f);
  spotCone(inner, outer, light.spotScale, light.spotOffset);
  return irradianceOf(sampleLight(light, vec3(std::sin(angle), std::cos(angle), 0.0f))).x;
}

TEST(SpotCone, IsFullInsideTheInnerAndDarkOutsideTheOuterAngle) {
  const float inner = 0.3f, outer = 0.7f;
  EXPECT_EQ(spotAt(inner, outer, 0.0f), 1.0f);
  EXPECT_NEAR(spotAt(inner, outer, inner), 1.0f, 1e-5f);
  EXPECT_NEAR(spotAt(inner, outer, outer), 0.0f, 1e-5f);
  EXPECT_EQ(spotAt(inner, outer, outer + 0.01f), 0.0f);
  EXPECT_EQ(spotAt(inner, outer, 3.0f), 0.0f);
}

// Cosines 1 (inner 0) and 1/2 (outer 60 degrees): at the cosine 3/4 the ramp is (3/4 - 1/2) * 2 = 1/2, squared 1/4.
TEST(SpotCone, RampsWithTheSquareOfTheCosine) {
  EXPECT_NEAR(spotAt(0.0f, std::acos(0.5f), std::acos(0.75f)), 0.25f, 1e-5f);
}

TEST(SpotCone, HardEdgeIsFinite) {
  float scale = 0.0f, offset = 0.0f;
  spotCone(0.5f, 0.5f, scale, offset);
  EXPECT_FLOAT_EQ(scale, 1000.0f);  // the extension's floor of 0.001 under the cosines' difference
  EXPECT_EQ(spotAt(0.5f, 0.5f, 0.45f), 1.0f);
  EXPECT_EQ(spotAt(0.5f, 0.5f, 0.55f), 0.0f);
}

}  // namespace
}  // namespace latelight::shared
