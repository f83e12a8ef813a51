// Helpers for the renderer's tests: a device under validation, optional models, pictures, and small test scenes.
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

// One device a process: that of test_device.h. Any validation message fails the test that caused it.
class RenderTest : public testing::Test {
 protected:
  static vk::Device& device();
  void SetUp() override { device().validationMessages(); }
  void TearDown() override;
};

// A test's name, of a file's.
std::string caseName(const testing::TestParamInfo<std::string>& info);

// LATELIGHT_TEST_RASTER=compute: the raster of all tests that say none themselves.
Raster testRaster();

// All that can be drawn; with the raster compute one of each kind, since writing a layout is the same function there.
std::vector<const Layout*> layoutsToMeet();

inline Settings settingsOf(uint32_t width, uint32_t height, std::vector<output::Aov> aovs = {}) {
  Settings settings;
  settings.width = width;
  settings.height = height;
  settings.display = false;
  settings.raster = testRaster();
  settings.shadows = ShadowFormat::None;             // most tests know what unshadowed light is
  settings.shadowAtlas = 1024;                       // for small pictures: a CPU fills every texel
  settings.lighting = &findTechnique("fullscreen");  // the reference
  settings.aovs = std::move(aovs);
  return settings;
}

// With the raster compute where what they ask for takes it.
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

// builtin:hall with few triangles and lights, made once a process.
const scene::Scene& hall();

// The scene's first camera, or the automatic one.
scene::Camera cameraOf(const scene::Scene& scene, uint32_t width, uint32_t height);

// --- hand-made scenes: glTF's frame, where +Z is towards the viewer -------------------------------------------------

// The square [-1, 1]^2 in the plane z = 0, facing +Z: u grows along +X (the tangent), v downwards, both from 0 to 1; UV
// set 1 is UV set 0 times (2, 3), and vertex colours are white. Its diagonal runs from lower left to upper right.
scene::Mesh squareMesh(bool extras = false);
// That mesh, and four materials: double-sided where bit 0 is set, and where bit 1 is, with holes that an alpha mask
// cuts, of texels so large that level 0 of the texture is what is sampled.
void addSquareOfFourKinds(scene::Scene& scene);

// A sphere around the origin with analytic normals, coarse enough for pictures to be cheap.
scene::Mesh sphereMesh(float radius);

// Orthographic, looking along -Z from z = `distance` at the square [-half, half]^2, which fills a square picture.
scene::Camera frontCamera(float half = 1, float distance = 4);

// The same place and direction, perspective, infinite far plane.
scene::Camera frontPerspective(float verticalFov, float distance);

// A light that is the same from everywhere: radiance 1 in every direction.
scene::Environment constantEnvironment();

// One RGBA texture with its full mip chain; `colors` are its pixels, rows from the top.
scene::Texture textureOf(uint32_t width, uint32_t height, bool srgb, const std::vector<glm::u8vec4>& colors);

// Puts texture `index` into a slot of a material.
void setTexture(scene::Material& material, uint32_t slot, int index, scene::Sampler sampler = {});
inline constexpr scene::Sampler kNearest{
    .magnify = scene::Filter::Nearest, .minify = scene::Filter::Nearest, .mip = scene::MipFilter::None};

}  // namespace latelight::render::test
