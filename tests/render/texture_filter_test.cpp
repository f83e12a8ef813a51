// Texture filtering in compute shaders, for devices without descriptor indexing, against sampling in the graphics
// pipeline. docs/limits.md states their differences.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render/support.h"
#include "scene/textures/texture.h"

namespace latelight::render::test {
namespace {

class TextureFilterTest : public RenderTest {
 protected:
  static std::vector<uint8_t> imageWith(Raster raster) {
    Settings s = settingsOf(320, 180);
    s.display = true;
    s.raster = raster;
    return renderOne(device(), hall(), cameraOf(hall(), s.width, s.height), s).display;
  }
};

TEST_F(TextureFilterTest, RastersDifferInTheHallByAtMostTheDocumentedLimits) {
  if (device().maxTextureArray() != 0) GTEST_SKIP() << "this device has descriptor indexing";
  const std::vector<uint8_t> drawn = imageWith(Raster::Hardware), computed = imageWith(Raster::Compute);
  ASSERT_EQ(drawn.size(), computed.size());
  const size_t pixels = drawn.size() / 4;
  size_t beyondOne = 0, beyondTwo = 0;
  double sum = 0;
  for (size_t i = 0; i < pixels; ++i) {
    int difference = 0;
    for (size_t c = 0; c < 4; ++c) difference = std::max(difference, std::abs(drawn[4 * i + c] - computed[4 * i + c]));
    beyondOne += difference > 1, beyondTwo += difference > 2, sum += difference;
  }
  const auto share = [&](size_t count) { return static_cast<double>(count) / static_cast<double>(pixels); };
  EXPECT_LT(share(beyondOne), 0.04);
  EXPECT_LT(share(beyondTwo), 0.015);
  EXPECT_LT(sum / static_cast<double>(pixels), 0.6);
}

// A square whose texture has mip levels that differ by a constant, so the metalness output identifies the sampled
// level.
scene::Scene squareOfLevels(float texelsPerPixel, uint32_t pixels) {
  constexpr uint32_t kTexels = 256;
  scene::SceneBuilder builder{"levels"};
  scene::Scene& scene = builder.scene;
  scene.meshes.push_back(squareMesh());
  scene::Texture texture = scene::makeTexture({kTexels, kTexels}, false, "levels");
  size_t offset = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const size_t bytes = 4 * size_t{kTexels >> level} * (kTexels >> level);
    std::fill_n(texture.pixels.get() + offset, bytes, static_cast<std::byte>(20 * level));
    offset += bytes;
  }
  scene.textures.push_back(std::move(texture));
  scene::Material material = scene::plainMaterial("levels", glm::vec3(1), 1, 1);
  setTexture(material, shared::kTextureMetallicRoughness, 0, {.mip = scene::MipFilter::Linear});
  const float scale = texelsPerPixel * static_cast<float>(pixels) / kTexels;
  material.data.transforms[shared::kTextureMetallicRoughness].row0 = {scale, 0, 0};
  material.data.transforms[shared::kTextureMetallicRoughness].row1 = {0, scale, 0};
  scene.materials.push_back(std::move(material));
  builder.addInstance("square", builder.kRoot, 0, 0, glm::mat4(1));
  return std::move(scene);
}

// Drivers may approximate the level of detail (Vulkan 1.3, section 16.6.7). Compute shaders of devices
// without descriptor indexing compute its logarithm themselves.
TEST_F(TextureFilterTest, LevelsFollowTheLogarithmOfTheFootprint) {
  constexpr uint32_t kPixels = 16;
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    const bool isExact = raster == Raster::Compute && device().maxTextureArray() == 0;
    for (int eighth = 0; eighth < 8; ++eighth) {
      const float level = 2 + static_cast<float>(eighth) / 8;
      Settings s = settingsOf(kPixels, kPixels, {output::Aov::Metallic});
      s.raster = raster;
      const output::FrameOutput frame =
          renderOne(device(), squareOfLevels(std::exp2(level), kPixels), frontCamera(), s);
      const float seen = imageOf(frame, output::Aov::Metallic).values[kPixels * kPixels / 2] * 255 / 20;
      fmt::print("{}: level {} is sampled at {:.3f}\n", isExact ? "in shaders" : "by the driver", level, seen);
      // The driver rounds filtered texels of a given level to 8 bits.
      EXPECT_NEAR(seen, level, isExact ? 0.5f / 20 + 1e-3f : 0.1f);
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
