// Occlusion and metallic-roughness maps that are one image on a CPU device (gpu_scene/occlusion_pairs.h): which
// textures are paired, and that surfaces have the values of the files' textures, also after edits.
#include "render/gpu_scene/occlusion_pairs.h"

#include <fmt/core.h>

#include "render/support.h"
#include "scene/edit.h"

namespace latelight::render::test {
namespace {

using glm::u8vec4;
using output::Aov;
using shared::kTextureBaseColor, shared::kTextureMetallicRoughness, shared::kTextureOcclusion;

constexpr int kNone = OcclusionPairs::kNone;
constexpr uint32_t kPairSize = 32;

// All texels are alike, so that values do not depend on filters and coordinates.
scene::Texture plainTexture(u8vec4 color, uint32_t side = 4, bool srgb = false) {
  return textureOf(side, side, srgb, std::vector<u8vec4>(size_t{side} * side, color));
}

constexpr u8vec4 kRoughTexel{10, 102, 153, 255}, kOcclusionTexel{51, 20, 30, 255};

// Two squares, each with a material: the left half of an image shows the first one, the right half the second one.
struct TwoSquares {
  scene::SceneBuilder builder{"pairs"};
  scene::Scene& scene = builder.scene;

  TwoSquares() {
    scene.meshes.push_back(squareMesh());
    for (uint32_t i = 0; i < 2; ++i) {
      scene.materials.push_back(scene::plainMaterial("material", glm::vec3(1), 1, 1));
      glm::mat4 local(1);
      local[0].x = 0.5f;
      local[3].x = i == 0 ? -0.5f : 0.5f;
      builder.addInstance("square", builder.kRoot, 0, i, local);
    }
    scene.textures = {plainTexture(kRoughTexel), plainTexture(kOcclusionTexel)};
    for (scene::Material& material : scene.materials) {
      setTexture(material, kTextureMetallicRoughness, 0);
      setTexture(material, kTextureOcclusion, 1);
    }
  }
};

TEST(OcclusionPairs, MapsThatMaterialsUseTogetherAreOneImage) {
  const TwoSquares squares;
  const OcclusionPairs pairs = occlusionPairs(squares.scene);
  EXPECT_EQ(pairs.occlusionOf, (std::vector{1, kNone}));
  EXPECT_EQ(pairs.imageOf, (std::vector{0, 0}));
}

TEST(OcclusionPairs, MapsThatAnythingElseSamplesAreNot) {
  const auto expectNoPair = [](const char* reason, auto change) {
    SCOPED_TRACE(reason);
    TwoSquares squares;
    change(squares.scene);
    const OcclusionPairs pairs = occlusionPairs(squares.scene);
    EXPECT_EQ(pairs.occlusionOf, std::vector(squares.scene.textures.size(), kNone));
    for (size_t i = 0; i < pairs.imageOf.size(); ++i) EXPECT_EQ(pairs.imageOf[i], static_cast<int>(i));
  };
  expectNoPair("another slot samples the occlusion map",
               [](scene::Scene& s) { setTexture(s.materials[1], kTextureBaseColor, 1); });
  expectNoPair("another slot samples the roughness map",
               [](scene::Scene& s) { setTexture(s.materials[1], kTextureBaseColor, 0); });
  expectNoPair("one texture is both", [](scene::Scene& s) {
    for (scene::Material& material : s.materials) setTexture(material, kTextureOcclusion, 0);
  });
  expectNoPair("a material has another occlusion map", [](scene::Scene& s) {
    s.textures.push_back(plainTexture(kOcclusionTexel));
    setTexture(s.materials[1], kTextureOcclusion, 2);
  });
  expectNoPair("a material has no occlusion map",
               [](scene::Scene& s) { s.materials[1].slots[kTextureOcclusion] = {}; });
  expectNoPair("the sizes differ", [](scene::Scene& s) { s.textures[1] = plainTexture(kOcclusionTexel, 8); });
  expectNoPair("the occlusion map is coded",
               [](scene::Scene& s) { s.textures[1] = plainTexture(kOcclusionTexel, 4, true); });
}

TEST(OcclusionPairs, TheImageHasTheRedChannelOfTheOcclusionMapInAllLevels) {
  const scene::Texture rough = plainTexture(kRoughTexel), occlusion = plainTexture(kOcclusionTexel);
  const auto pixels = withOcclusion(rough, occlusion);
  ASSERT_EQ(rough.bytes(), 4u * (16 + 4 + 1));
  for (size_t i = 0; i < rough.bytes(); i += 4)
    for (int c = 0; c < 4; ++c)
      EXPECT_EQ(static_cast<int>(pixels[i + static_cast<size_t>(c)]), c == 0 ? kOcclusionTexel.r : kRoughTexel[c]);
}

class OcclusionPairsTest : public RenderTest {
 protected:
  struct Values {
    float ao, roughness, metallic;
    glm::vec3 albedo{1};
  };
  static void expectValues(Renderer& renderer, Values left, Values right) {
    Settings settings = settingsOf(kPairSize, kPairSize, {Aov::Ao, Aov::Roughness, Aov::Metallic, Aov::Albedo});
    const scene::Camera camera = frontCamera();
    for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
      SCOPED_TRACE(raster == Raster::Hardware ? "hardware" : "compute");
      settings.raster = raster;
      const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
      for (const bool isRight : {false, true}) {
        SCOPED_TRACE(isRight ? "right" : "left");
        const Values& expected = isRight ? right : left;
        const size_t pixel = (kPairSize / 2) * kPairSize + (isRight ? 3 : 1) * kPairSize / 4;
        EXPECT_NEAR(imageOf(frame, Aov::Ao).values[pixel], expected.ao, 1e-3f);
        EXPECT_NEAR(imageOf(frame, Aov::Roughness).values[pixel], expected.roughness, 1e-3f);
        EXPECT_NEAR(imageOf(frame, Aov::Metallic).values[pixel], expected.metallic, 1e-3f);
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(vec3At(imageOf(frame, Aov::Albedo), pixel)[c], expected.albedo[c], 1e-3f);
      }
    }
  }
};

TEST_F(OcclusionPairsTest, SurfacesHaveTheValuesOfTheirTexturesAfterEdits) {
  constexpr float kAo = 0.2f, kRoughness = 0.4f, kMetallic = 0.6f;  // the texels
  TwoSquares squares;
  scene::Scene& scene = squares.scene;
  Renderer renderer(device(), scene, nullptr);
  expectValues(renderer, {kAo, kRoughness, kMetallic}, {kAo, kRoughness, kMetallic});
  scene::setTexture(scene, 1, plainTexture({204, 0, 0, 255}));
  expectValues(renderer, {0.8f, kRoughness, kMetallic}, {0.8f, kRoughness, kMetallic});
  scene::setTexture(scene, 0, plainTexture({0, 51, 102, 255}));
  expectValues(renderer, {0.8f, 0.2f, 0.4f}, {0.8f, 0.2f, 0.4f});
  // The base color shows the map's own red channel.
  scene::Material material = scene.materials[1];
  setTexture(material, kTextureBaseColor, 0);
  setMaterial(scene, 1, material);
  expectValues(renderer, {0.8f, 0.2f, 0.4f}, {0.8f, 0.2f, 0.4f, {0, 0.2f, 0.4f}});
  material.slots[kTextureBaseColor] = {};
  material.data.textures &= ~(1u << kTextureBaseColor);
  setMaterial(scene, 1, material);
  expectValues(renderer, {0.8f, 0.2f, 0.4f}, {0.8f, 0.2f, 0.4f});
  material.slots[kTextureOcclusion] = {};
  material.data.textures &= ~(1u << kTextureOcclusion);
  setMaterial(scene, 1, material);
  expectValues(renderer, {0.8f, 0.2f, 0.4f}, {1, 0.2f, 0.4f});
}

// Half of each map is another value, and the transforms of the slots select different halves.
TEST_F(OcclusionPairsTest, EachSlotHasItsOwnTransformAndSampler) {
  TwoSquares squares;
  scene::Scene& scene = squares.scene;
  const auto halves = [](u8vec4 left, u8vec4 right) { return textureOf(2, 1, false, {left, right}); };
  scene.textures = {halves({0, 51, 102, 255}, {0, 153, 204, 255}), halves({51, 0, 0, 255}, {204, 0, 0, 255})};
  const auto atU = [](float u) { return shared::TextureTransform{glm::vec3(0, 0, u), glm::vec3(0, 1, 0), 0}; };
  for (uint32_t i = 0; i < 2; ++i) {
    scene::Material& material = scene.materials[i];
    setTexture(material, kTextureMetallicRoughness, 0, kNearest);
    setTexture(material, kTextureOcclusion, 1, kNearest);
    material.data.transforms[kTextureMetallicRoughness] = atU(i == 0 ? 0.25f : 0.75f);
    material.data.transforms[kTextureOcclusion] = atU(0.75f);
  }
  Renderer renderer(device(), scene, nullptr);
  expectValues(renderer, {0.8f, 0.2f, 0.4f}, {0.8f, 0.6f, 0.8f});
  // Beyond the right edge, occlusion repeats the left texel or clamps to the right one.
  for (uint32_t i = 0; i < 2; ++i) {
    scene::Material material = scene.materials[i];
    material.data.transforms[kTextureMetallicRoughness] = material.data.transforms[kTextureOcclusion] = atU(1.25f);
    if (i == 1) material.slots[kTextureOcclusion].sampler.wrapU = scene::Wrap::Clamp;
    setMaterial(scene, i, material);
  }
  expectValues(renderer, {0.2f, 0.2f, 0.4f}, {0.8f, 0.2f, 0.4f});
}

}  // namespace
}  // namespace latelight::render::test
