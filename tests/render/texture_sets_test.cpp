// Bindless textures, by index in one array, against one descriptor set per material, on devices that support both.
#include <fmt/core.h>

#include <algorithm>

#include "models/models.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/gltf_builder.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kTextureWidth = 320, kTextureHeight = 180;

class TextureSetsTest : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    const std::string uuid = device().info().uuid;
    indexed_ = std::make_unique<vk::Device>(
        vk::DeviceOptions{.selector = uuid, .validation = true, .descriptorIndexing = true});
    if (indexed_->maxTextureArray() == 0) GTEST_SKIP() << "skipped: the device has no descriptor indexing";
    bound_ = std::make_unique<vk::Device>(
        vk::DeviceOptions{.selector = uuid, .validation = true, .descriptorIndexing = false});
    ASSERT_EQ(bound_->maxTextureArray(), 0u);
  }
  void TearDown() override {
    RenderTest::TearDown();
    if (!bound_) return;
    for (vk::Device* own : {indexed_.get(), bound_.get()})
      for (const std::string& message : own->validationMessages()) ADD_FAILURE() << message;
  }
  void compare(const scene::Scene& scene, Settings settings) {
    const scene::Camera camera = cameraOf(scene, kTextureWidth, kTextureHeight);
    const scene::Environment sky = constantEnvironment();
    const output::FrameOutput one = renderOne(*indexed_, scene, camera, settings, &sky);
    const output::FrameOutput other = renderOne(*bound_, scene, camera, settings, &sky);
    for (const Aov aov : settings.aovs) {
      double worst = 0;
      for (size_t i = 0; i < imageOf(one, aov).values.size(); ++i)
        worst = std::max(worst, std::abs(double{imageOf(one, aov).values[i]} - imageOf(other, aov).values[i]));
      EXPECT_LT(worst, 1e-5) << output::info(aov).name;
    }
  }
  std::unique_ptr<vk::Device> indexed_, bound_;
};

TEST_F(TextureSetsTest, AHundredMaterialsLookAlike) {
  scene::Scene scene = scene::test::GltfBuilder::loadBytes(models::manyMaterialsModel(), "many.glb");
  for (const char* technique : {"clustered", "forward"})
    for (const uint32_t samples : {1u, 4u}) {
      SCOPED_TRACE(fmt::format("{} {}", technique, samples));
      Settings settings =
          settingsOf(kTextureWidth, kTextureHeight, {Aov::Color, Aov::Albedo, Aov::Normal, Aov::Roughness});
      settings.lighting = &findTechnique(technique);
      settings.aa.samples = samples;
      settings.raster = Raster::Hardware;  // with the raster compute, the two devices filter differently
      settings.shadows = ShadowFormat::D32;
      compare(scene, settings);
    }
}

TEST_F(TextureSetsTest, EditsAndAnisotropyTakeEffect) {
  scene::Scene scene = scene::test::GltfBuilder::loadBytes(models::manyMaterialsModel(), "many.glb");
  const scene::Camera camera = cameraOf(scene, kTextureWidth, kTextureHeight);
  Renderer renderer(*indexed_, scene, nullptr);
  for (uint32_t step = 0; step < 4; ++step) {
    Settings settings = settingsOf(kTextureWidth, kTextureHeight, {Aov::Albedo});
    settings.raster = Raster::Hardware;
    settings.anisotropy = step % 2 ? 1 : 8;
    for (uint32_t i = 0; i < 10; ++i) {
      const uint32_t material = 10 * step + i;
      scene::Material changed = scene.materials[material];
      changed.slots[shared::kTextureBaseColor].sampler = kNearest;
      setMaterialOf(scene, material, addMaterial(scene, changed));
    }
    const output::FrameOutput now = std::move(renderer.render({&camera, 1}, settings).front());
    EXPECT_EQ(imageOf(now, Aov::Albedo).values,
              imageOf(renderOne(*indexed_, scene, camera, settings), Aov::Albedo).values);
    compare(scene, settings);
  }
}

// Entries of the array are freed and reused, also by an image that has the same handle as the freed one.
TEST_F(TextureSetsTest, ReplacedRemovedAndAddedTexturesTakeEffect) {
  scene::Scene scene = scene::test::GltfBuilder::loadBytes(models::manyMaterialsModel(), "many.glb");
  const scene::Camera camera = cameraOf(scene, kTextureWidth, kTextureHeight);
  Renderer renderer(*indexed_, scene, nullptr);
  Settings settings = settingsOf(kTextureWidth, kTextureHeight, {Aov::Albedo});
  settings.raster = Raster::Hardware;
  const auto plain = [](uint32_t side, uint32_t step) {
    return textureOf(side, side, true, std::vector(side * side, glm::u8vec4(60 * step, 20 * side, 200, 255)));
  };
  std::vector<uint32_t> added;
  for (uint32_t step = 0; step < 4; ++step) {
    for (uint32_t i = 0; i < 8; ++i) {
      scene::Material material = scene.materials[i];
      if (step > 0) material.slots[shared::kTextureBaseColor].texture = -1, material.data.textures &= ~1u;
      setMaterial(scene, i, material);
      if (step > 0) removeTexture(scene, added[i]);
    }
    added.clear();
    for (uint32_t i = 0; i < 8; ++i) {
      added.push_back(addTexture(scene, plain(4u << i % 3, step)));
      scene::Material material = scene.materials[i];
      test::setTexture(material, shared::kTextureBaseColor, static_cast<int>(added[i]));
      setMaterial(scene, i, material);
    }
    if (step > 0) scene::setTexture(scene, added[3], plain(8, 0));
    const output::FrameOutput now = std::move(renderer.render({&camera, 1}, settings).front());
    EXPECT_EQ(imageOf(now, Aov::Albedo).values,
              imageOf(renderOne(*indexed_, scene, camera, settings), Aov::Albedo).values);
    compare(scene, settings);
  }
}

}  // namespace
}  // namespace latelight::render::test
