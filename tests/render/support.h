// Helpers for the renderer's tests: a device under validation, optional models, images, and small test scenes.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/submit/renderer.h"
#include "scene/environment/environment.h"
#include "scene/scene.h"
#include "scene/scene_builder.h"
#include "vk/device.h"

namespace latelight::render::test {

// All tests of a process share one device, which test_device.h selects. Any validation message fails the test that
// caused it.
class RenderTest : public testing::Test {
 protected:
  static vk::Device& device();
  // The same device with the code paths for GPUs (DeviceOptions::cpuShaders).
  static vk::Device& gpuPaths();
  void SetUp() override { device().validationMessages(); }
  void TearDown() override;
};

// A test's name, derived from the name of a file.
std::string caseName(const testing::TestParamInfo<std::string>& info);

// The raster of all tests that do not choose one: that of LATELIGHT_TEST_RASTER, or else hardware.
Raster testRaster();

// All layouts with targets. With the raster compute, one of each kind, because one function writes every layout there.
std::vector<const Layout*> layoutsToMeet();

inline Settings settingsOf(uint32_t width, uint32_t height, std::vector<output::Aov> aovs = {}) {
  Settings settings;
  settings.width = width;
  settings.height = height;
  settings.display = false;
  settings.raster = testRaster();
  settings.shadows = ShadowFormat::None;             // most tests expect unshadowed light
  settings.shadowAtlas = 1024;                       // for small images, because a CPU fills every texel
  settings.lighting = &findTechnique("fullscreen");  // the reference
  settings.aovs = std::move(aovs);
  return settings;
}

// Selects the raster compute if the settings require it.
inline Settings inTheirRaster(Settings settings) {
  if (takesCompute(settings)) settings.raster = Raster::Compute;
  return settings;
}

output::FrameOutput renderOne(vk::Device& device, const scene::Scene& scene, const scene::Camera& camera,
                              const Settings& settings, const scene::Environment* environment = nullptr);

const output::AovImage& imageOf(const output::FrameOutput& frame, output::Aov aov);
inline glm::vec3 vec3At(const output::AovImage& image, size_t pixel) {
  return {image.values[3 * pixel], image.values[3 * pixel + 1], image.values[3 * pixel + 2]};
}
inline glm::vec2 vec2At(const output::AovImage& image, size_t pixel) {
  return {image.values[2 * pixel], image.values[2 * pixel + 1]};
}

// builtin:hall with few triangles and lights, created once per process.
const scene::Scene& hall();

// The scene's first camera, or the automatic one.
scene::Camera cameraOf(const scene::Scene& scene, uint32_t width, uint32_t height);

// --- scenes in glTF's frame, where +Z points toward the viewer ------------------------------------------------------

// The square [-1, 1]^2 in the plane z = 0, facing +Z. u increases along +X (the tangent) and v downward, both from 0 to
// 1. UV set 1 is UV set 0 times (2, 3), and vertex colors are white. The diagonal runs from lower left to upper right.
scene::Mesh squareMesh(bool extras = false);
// Adds that mesh and four materials. Bit 0 of a material's index makes it double-sided. Bit 1 adds holes by an alpha
// mask, with texels so large that mip level 0 of the texture is sampled.
void addSquareOfFourKinds(scene::Scene& scene);

// A sphere around the origin with analytic normals, by default coarse enough to be rendered quickly.
scene::Mesh sphereMesh(float radius, uint32_t parallels = 16);

// An orthographic camera that looks along -Z from z = `distance` at the square [-half, half]^2, which fills a square
// image.
scene::Camera frontCamera(float half = 1, float distance = 4);

// A perspective camera with the same position and direction and an infinite far plane.
scene::Camera frontPerspective(float verticalFov, float distance);

// An environment with radiance 1 in every direction.
scene::Environment constantEnvironment();

// One RGBA texture with its full mip chain; `colors` are its texels, rows from the top.
scene::Texture textureOf(uint32_t width, uint32_t height, bool srgb, const std::vector<glm::u8vec4>& colors);

// Assigns texture `index` to a slot of a material.
void setTexture(scene::Material& material, uint32_t slot, int index, scene::Sampler sampler = {});
inline constexpr scene::Sampler kNearest{
    .magnify = scene::Filter::Nearest, .minify = scene::Filter::Nearest, .mip = scene::MipFilter::None};

}  // namespace latelight::render::test
