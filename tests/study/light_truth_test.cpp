// The ground truth of lighting compared with closed forms, and energy compensation compared with the ground truth.
#include "study/light_truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "scene/environment/environment.h"
#include "shared/shade.h"

namespace latelight::study {
namespace {

using glm::dvec3;
using glm::vec3;
using shared::Surface;

constexpr uint32_t kSamples = 4096;

dvec3 seen(const EnvironmentTruth& truth, const shared::Surface& s, const dvec3& eye) {
  return truth.radiance(s, eye, Bounces(s, eye, 4 * kSamples), kSamples);
}

scene::FloatImage pictureOf(uint32_t height, const std::function<vec3(const dvec3&)>& radiance) {
  scene::FloatImage picture(2 * height, height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < 2 * height; ++x) {
      const double polar = (y + 0.5) * std::numbers::pi / height;
      const double turn = ((x + 0.5) / (2.0 * height) - 0.5) * 2 * std::numbers::pi;
      const vec3 light =
          radiance({std::sin(polar) * std::cos(turn), -std::sin(polar) * std::sin(turn), std::cos(polar)});
      std::copy_n(&light.x, 3, picture.at(x, y));
    }
  return picture;
}

Surface surfaceOf(vec3 baseColor, float metallic, float roughness, vec3 normal) {
  Surface s = shared::emptySurface();
  s.baseColor = baseColor;
  s.metallic = metallic;
  s.roughness = roughness;
  s.f0 = vec3(0.04f);
  s.f90 = 1;
  s.normal = glm::normalize(normal);
  return s;
}

// A direction whose angle to the normal has this cosine.
dvec3 eyeAt(const Surface& s, double cosine) {
  const dvec3 n(s.normal), across = glm::normalize(glm::cross(n, dvec3(0.3, 0.5, -0.8)));
  return n * cosine + across * std::sqrt(1 - cosine * cosine);
}

constexpr float kRoughness[] = {0.1f, 0.3f, 0.5f, 0.75f, 1.0f};
constexpr double kCosines[] = {0.1, 0.3, 0.6, 0.95};

TEST(LightTruth, WhiteSurfacesVanishInAWhiteRoom) {
  const EnvironmentTruth room(pictureOf(32, [](const dvec3&) { return vec3(1); }));
  for (const float metallic : {0.0f, 0.5f, 1.0f})
    for (const float roughness : kRoughness)
      for (const double cosine : kCosines) {
        const Surface s = surfaceOf(vec3(1), metallic, roughness, vec3(0.2f, -0.7f, 0.4f));
        EXPECT_NEAR(seen(room, s, eyeAt(s, cosine)).y, 1.0, 0.004)
            << "metallic " << metallic << ", roughness " << roughness << ", n.v " << cosine;
      }
}

TEST(LightTruth, MatteSurfacesShowTheIrradianceOfAGradient) {
  const vec3 slope(0.3f, -0.2f, 0.5f);
  const EnvironmentTruth gradient(
      pictureOf(128, [&](const dvec3& d) { return vec3(1.0f + glm::dot(slope, vec3(d))); }));
  for (const vec3 normal : {vec3(0, 0, 1), vec3(0.6f, -0.5f, -0.3f), vec3(-0.8f, 0.1f, 0.2f)}) {
    Surface s = surfaceOf(vec3(0.5f), 0, 0.5f, normal);
    s.f0 = vec3(0), s.f90 = 0;
    EXPECT_NEAR(seen(gradient, s, eyeAt(s, 0.5)).x, 0.5 * (1 + 2.0 / 3 * glm::dot(slope, s.normal)), 2e-3);
  }
}

TEST(LightTruth, SmoothMetalsMirror) {
  const EnvironmentTruth halves(
      pictureOf(128, [](const dvec3& d) { return d.x > 0 ? vec3(1, 0.5f, 0.25f) : vec3(0); }));
  for (const float side : {-1.0f, 1.0f}) {
    const Surface s = surfaceOf(vec3(0.9f), 1, 0.05f, vec3(side * 0.5f, 0.2f, 0.8f));
    const dvec3 eye(s.normal);
    EXPECT_NEAR(seen(halves, s, eye).x, side > 0 ? 0.9 : 0, 2e-3);
    EXPECT_NEAR(seen(halves, s, eye).z, side > 0 ? 0.25 * 0.9 : 0, 2e-3);
  }
}

// A small bright sun, which neither the samples of the lobe nor those of the cosine find: the BRDF times its
// irradiance.
TEST(LightTruth, SmallSunsLightByTheBrdf) {
  const dvec3 towards = glm::normalize(dvec3(0.4, -0.3, 0.85));
  const double radius = 0.02;
  const scene::FloatImage picture =
      pictureOf(512, [&](const dvec3& d) { return vec3(glm::dot(d, towards) > std::cos(radius) ? 1000.0f : 0.0f); });
  double solidAngle = 0;
  for (uint32_t y = 0; y < picture.height; ++y)
    for (uint32_t x = 0; x < picture.width; ++x)
      if (picture.at(x, y)[0] > 0)
        solidAngle +=
            2 * std::numbers::pi / picture.width *
            (std::cos(y * std::numbers::pi / picture.height) - std::cos((y + 1) * std::numbers::pi / picture.height));
  const EnvironmentTruth sun(picture);
  for (const float roughness : {0.2f, 0.4f}) {
    // A dark dielectric: light that bounces between facets, and its effect on the diffuse part, are negligible.
    const Surface s = surfaceOf(vec3(0), 0, roughness, vec3(0.1f, 0, 1));
    const dvec3 eye = eyeAt(s, 0.8);
    const double cosine = glm::dot(dvec3(s.normal), towards);
    const double expected = gltfBrdf(s, towards, eye).x * cosine * 1000 * solidAngle;
    EXPECT_NEAR(seen(sun, s, eye).x, expected, 0.04 * expected) << roughness;
  }
}

// The energy that shading adds for multiple bounces (surfaceReflectance()) equals the result of the walk over facets in
// a white room, where it is the only difference: a colored metal's albedo.
TEST(LightTruth, CompensatedEnergyIsThatOfTheWalk) {
  const EnvironmentTruth room(pictureOf(32, [](const dvec3&) { return vec3(1); }));
  constexpr uint32_t kTable = 64;
  const std::vector<glm::vec2> table = scene::ggxReflectanceTable(kTable);
  double worst = 0;
  for (const uint32_t row : {12u, 25u, 38u, 51u, 63u})
    for (const uint32_t column : {8u, 20u, 38u, 60u}) {
      const Surface s = surfaceOf(vec3(0.9f, 0.5f, 0.2f), 1, (float(row) + 0.5f) / kTable, vec3(0.2f, -0.7f, 0.4f));
      const dvec3 truth = seen(room, s, eyeAt(s, (column + 0.5) / kTable));
      const shared::SurfaceReflectance r = shared::surfaceReflectance(s, table[row * kTable + column]);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(truth[c] - r.once[c] - r.scattered[c]));
    }
  EXPECT_LT(worst, 0.025);
  RecordProperty("worst albedo", std::to_string(worst));
}

}  // namespace
}  // namespace latelight::study
