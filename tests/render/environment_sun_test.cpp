// Environments with a sun that is too bright for half floats, against closed forms of the surfaces that it lights.
#include <fmt/core.h>

#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "render/support.h"
#include "scene/environment/filter.h"
#include "scene/framing.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using glm::vec3;
using output::Aov;

// A dark environment with a disk of this radiance at an elevation over +X of glTF's frame (the image's center column).
// `irradiance` is that of a horizontal plane, summed over the disk's pixels: L times solid angle times sin(elevation).
struct DiskPicture {
  scene::FloatImage picture{512, 256};
  double irradiance = 0, solidAngle = 0;

  DiskPicture(double elevation, float radiance) {
    constexpr double kPi = std::numbers::pi, kRadius = 0.02;
    const dvec3 toward(std::cos(elevation), std::sin(elevation), 0);
    for (uint32_t y = 0; y < picture.height; ++y)
      for (uint32_t x = 0; x < picture.width; ++x) {
        const double polar = (y + 0.5) * kPi / picture.height, turn = ((x + 0.5) / picture.width - 0.5) * 2 * kPi;
        const dvec3 d(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn));
        if (glm::length(d - toward) > kRadius) continue;
        std::fill_n(picture.at(x, y), 3, radiance);
        const double area =
            (std::cos(y * kPi / picture.height) - std::cos((y + 1) * kPi / picture.height)) * 2 * kPi / picture.width;
        solidAngle += area;
        irradiance += radiance * area * std::cos(polar);
      }
  }
};

class EnvironmentSun : public RenderTest {
 protected:
  // A square that faces the zenith, viewed from above.
  static scene::Scene ground(float albedo, float metallic, float roughness) {
    scene::SceneBuilder builder("ground");
    builder.scene.meshes.push_back(squareMesh());
    scene::Material material = scene::plainMaterial("ground", vec3(albedo), metallic, roughness);
    if (metallic == 0) material.data.specular = 0;  // Lambertian
    builder.scene.materials.push_back(material);
    builder.addInstance("ground", builder.kRoot, 0, 0, glm::rotate(glm::mat4(1), -shared::kPi / 2, vec3(1, 0, 0)));
    return std::move(builder.scene);
  }
  // The radiance at the image's center, viewed along `direction` of glTF's frame.
  static vec3 radiance(const scene::Scene& scene, const scene::Environment& environment, vec3 direction,
                       float exposure = 0, float rotation = 0) {
    Settings settings = settingsOf(3, 3, {Aov::Color});
    settings.exposure = exposure;
    settings.environmentRotation = rotation;
    const scene::Camera camera = scene::lookAt(scene, -5.0f * direction, {}, {}, 0.1f);
    const output::FrameOutput frame = renderOne(device(), scene, camera, settings, &environment);
    const float* pixel = &imageOf(frame, Aov::Color).values[4 * 4];
    return {pixel[0], pixel[1], pixel[2]};
  }
};

// The tolerance of 2 % consists of 1 % for the maps and the rounding of half floats.
TEST_F(EnvironmentSun, LightsAPlaneByItsSolidAngle) {
  const scene::Scene scene = ground(0.5f, 0, 1);
  const vec3 down = glm::normalize(vec3(0.001f, -1, 0));
  for (const double degrees : {20.0, 60.0})
    for (const float bright : {3e4f, 3e5f, 1e9f}) {
      SCOPED_TRACE(fmt::format("{} degrees, {}", degrees, bright));
      const DiskPicture sun(degrees * std::numbers::pi / 180, bright);
      const scene::Environment environment = scene::filterEnvironment(sun.picture);
      const float exposure = bright > 1e6f ? -10.0f : 0.0f;
      const double expected = 0.5 / std::numbers::pi * sun.irradiance * std::exp2(exposure);
      EXPECT_NEAR(radiance(scene, environment, down, exposure).x, expected, 0.02 * expected);
      // Rotating the environment about the zenith changes nothing.
      EXPECT_NEAR(radiance(scene, environment, down, exposure, 2).x, expected, 0.02 * expected);
    }
}

// A rough metal that mirrors the sun: L times solid angle times D(0) / (4 n.v) for a reflectance of 1, where masking is
// nearly 1. The renderer approximates a lobe (docs/accuracy.md), so the test allows 25 %. The error must be the same
// for a sun that half floats can represent and for brighter suns; tests/scene compares the maps themselves with the
// integral.
TEST_F(EnvironmentSun, KeepsItsLightInLobes) {
  constexpr float kRoughness = 0.5f;
  const scene::Scene scene = ground(1, 1, kRoughness);
  const double elevation = 80 * std::numbers::pi / 180, alpha = kRoughness * kRoughness, facing = std::sin(elevation);
  const vec3 fromTheOtherSide(std::cos(elevation), -facing, 0);
  const auto share = [&](float bright, float exposure) {
    const DiskPicture sun(elevation, bright);
    const scene::Environment environment = scene::filterEnvironment(sun.picture);
    const double expected = bright * sun.solidAngle / (std::numbers::pi * alpha * alpha) / (4 * facing);
    return radiance(scene, environment, fromTheOtherSide, exposure).x / (expected * std::exp2(exposure));
  };
  const double halfFloatShare = share(6e4f, 0);
  EXPECT_NEAR(halfFloatShare, 1, 0.25);
  for (const float bright : {3e5f, 1e9f})
    EXPECT_NEAR(share(bright, bright > 1e6f ? -14.0f : -2.0f), halfFloatShare, 2e-3);
}

// Where nothing is drawn, the background shows the sun itself, and the neighbors of its disk are dark.
TEST_F(EnvironmentSun, IsTheBackground) {
  const scene::Scene scene = ground(0.5f, 0, 1);
  const DiskPicture sun(0.5, 1e9f);
  const scene::Environment environment = scene::filterEnvironment(sun.picture);
  Settings settings = settingsOf(3, 3, {Aov::Color});
  settings.background.kind = Background::Environment;
  settings.exposure = -20;
  const vec3 toward(std::cos(0.5f), std::sin(0.5f), 0);
  const scene::Camera camera = scene::lookAt(scene, vec3(0, 3, 0), vec3(0, 3, 0) + toward, {}, 0.3f);
  const output::FrameOutput frame = renderOne(device(), scene, camera, settings, &environment);
  EXPECT_NEAR(imageOf(frame, Aov::Color).values[4 * 4], 1e9 * 0x1p-20, 1e9 * 0x1p-20 * 1e-3);
  EXPECT_EQ(imageOf(frame, Aov::Color).values[0], 0);
}

}  // namespace
}  // namespace latelight::render::test
