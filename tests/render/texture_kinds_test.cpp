// The texture properties for which lavapipe compiles separate shaders.
#include "render/gpu_scene/texture_kinds.h"

#include <gmock/gmock.h>

#include <map>

#include "models/models.h"
#include "render/support.h"
#include "scene/gltf_builder.h"

namespace latelight::render::test {
namespace {

constexpr scene::Sampler kRepeat, kClamp{.wrapU = scene::Wrap::Clamp, .wrapV = scene::Wrap::Clamp};

scene::Material materialOf(std::map<uint32_t, scene::Sampler> slots) {
  scene::Material material;
  for (const auto& [slot, sampler] : slots) setTexture(material, slot, 0, sampler);
  return material;
}

size_t combinationsOf(const std::vector<SlotSamplers>& samplers) {
  std::vector<SlotSamplers> different;
  for (const SlotSamplers& one : samplers)
    if (std::ranges::find(different, one) == different.end()) different.push_back(one);
  return different.size();
}

TEST(SlotSamplers, EmptySlotsTakeTheSamplersOfOtherMaterials) {
  const auto samplers = slotSamplers(
      {materialOf({}), materialOf({{0, kClamp}}), materialOf({{2, kRepeat}}), materialOf({{0, kClamp}, {2, kRepeat}})});
  EXPECT_EQ(combinationsOf(samplers), 1u);
  EXPECT_EQ(samplers[0][0], kClamp);
  EXPECT_EQ(samplers[0][2], kRepeat);
  EXPECT_FALSE(samplers[0][1]);
}

TEST(SlotSamplers, TexturesKeepTheirSamplers) {
  const scene::Scene scene = scene::test::GltfBuilder::loadBytes(models::manyMaterialsModel(), "many.glb");
  ASSERT_EQ(scene.materials.size(), 100u);
  ASSERT_EQ(scene.textures.size(), 50u);
  const auto samplers = slotSamplers(scene.materials);
  for (size_t i = 0; i < scene.materials.size(); ++i)
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
      const scene::TextureSlot& bound = scene.materials[i].slots[slot];
      if (bound.texture < 0) continue;
      EXPECT_EQ(samplers[i][slot], bound.sampler) << i << " " << slot;
    }
  EXPECT_LE(combinationsOf(samplers), 20u);  // three samplers in up to five slots
}

class TextureKinds : public RenderTest {};

TEST_F(TextureKinds, OnlyMixedTextureSizesAreUnified) {
  const auto texture = [](uint32_t width, uint32_t height) {
    return textureOf(width, height, false, std::vector<glm::u8vec4>(size_t{width} * height));
  };
  std::vector<scene::Texture> textures;
  textures.push_back(texture(4, 8));
  EXPECT_FALSE(unifiesTextureSizes(device(), textures));
  textures.push_back(texture(4, 6));
  EXPECT_EQ(unifiesTextureSizes(device(), textures), device().isCpu());
  const uint32_t maxSize = device().properties().limits.maxImageDimension2D;
  EXPECT_TRUE(getsOddBase(device(), 4, 8));
  EXPECT_TRUE(getsOddBase(device(), 1, 6));
  EXPECT_FALSE(getsOddBase(device(), 3, 6));
  EXPECT_FALSE(getsOddBase(device(), maxSize, 4));
  EXPECT_FALSE(getsOddBase(device(), maxSize / 2, 4));
  EXPECT_TRUE(getsOddBase(device(), maxSize / 4, 4));
}

}  // namespace
}  // namespace latelight::render::test
