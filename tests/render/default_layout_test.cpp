// Lighting from the default layout equals lighting from floats, within one 8-bit level, on materials that are hard to
// store, on the built-in scenes, and on real models.
#include <fmt/core.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "long_tests.h"
#include "models/models.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::vec3;

// Differences of 8-bit images: the largest one in levels, and the fraction of pixels that differ by more than one
// level.
struct Apart {
  int most = 0;
  double beyond = 0;
};
Apart apart(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  EXPECT_EQ(a.size(), b.size());
  Apart result;
  size_t beyond = 0;
  for (size_t i = 0; i < a.size(); i += 4) {
    int worst = 0;
    for (size_t c = 0; c < 4; ++c) worst = std::max(worst, std::abs(a[i + c] - b[i + c]));
    beyond += worst > 1;
    result.most = std::max(result.most, worst);
  }
  result.beyond = static_cast<double>(beyond) / (static_cast<double>(a.size()) / 4);
  return result;
}

size_t brighterThan(const std::vector<uint8_t>& picture, int level) {
  size_t count = 0;
  for (size_t i = 0; i < picture.size(); i += 4)
    count += std::max({picture[i], picture[i + 1], picture[i + 2]}) > level;
  return count;
}

class DefaultLayoutTest : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    // The loss of a layout does not depend on the raster.
    if (testRaster() == Raster::Compute) LATELIGHT_SKIP_UNLESS_ALL();
  }
  static void expectExact(const scene::Scene& scene, const scene::Environment* environment, Settings settings,
                          const char* name) {
    SCOPED_TRACE(name);
    const scene::Camera camera = cameraOf(scene, settings.width, settings.height);
    settings.display = true;
    Renderer renderer(device(), scene, environment);
    const auto render = [&](const std::string& layout) {
      settings.layout = &findLayout(layout);
      return std::move(renderer.render({&camera, 1}, settings).front().display);
    };
    const std::vector<uint8_t> exact = render("exact"), stored = render(Settings().layout->name), thin = render("thin");
    EXPECT_GT(brighterThan(exact, 20), exact.size() / 4 / 20);  // the image is not nearly black
    const Apart difference = apart(stored, exact), thins = apart(thin, exact);
    fmt::print("{}: {} levels apart at most, {:.4f} % of the pixels by more than one; thin {}, {:.4f} %\n", name,
               difference.most, 100 * difference.beyond, thins.most, 100 * thins.beyond);
    EXPECT_LE(difference.most, 2);
    EXPECT_LE(difference.beyond, 0.001);
  }
};

// --- materials that are hard to store -------------------------------------------------------------------------------

// Spheres in rows: metalness varies across, roughness downward, and reflectance with a period of its own.
scene::Scene oddSpheres(float strength) {
  constexpr float kMetalness[] = {0, 0.003f, 0.1f, 0.47f, 0.891f, 0.99f, 1};
  constexpr float kRoughness[] = {0, 0.04f, 0.11f, 0.3f, 0.62f, 1};
  struct Reflectance {
    float ior, specular;
    vec3 tint;
  };
  const Reflectance reflectances[] = {{1.5f, 1, vec3(1)},
                                      {1, 1, vec3(1)},
                                      {2.4f, 1, vec3(1)},
                                      {1.5f, 0, vec3(1)},
                                      {1.5f, 0.35f, vec3(1)},
                                      {1.5f, 1, vec3(0.9f, 0.4f, 1.7f)},
                                      {1.8f, 0.6f, vec3(1, 0.1f, 0.05f)},
                                      {1.33f, 1, vec3(1)}};
  const vec3 colors[] = {{0.8f, 0.5f, 0.2f}, {0.02f, 0.004f, 0.001f}, vec3(1), {0.05f, 0.3f, 0.9f}, vec3(0.18f)};
  scene::SceneBuilder builder("odd spheres");
  scene::Scene& scene = builder.scene;
  scene.meshes.push_back(sphereMesh(0.47f));
  scene.textures.push_back(
      textureOf(2, 2, false, {{90, 128, 230, 255}, {160, 100, 230, 255}, {128, 160, 240, 255}, {128, 128, 255, 255}}));
  scene.textures.push_back(  // roughness in green, metalness in blue
      textureOf(2, 2, false, {{0, 255, 227, 255}, {0, 30, 255, 255}, {0, 101, 17, 255}, {0, 200, 128, 255}}));
  uint32_t index = 0;
  for (size_t row = 0; row < std::size(kRoughness); ++row)
    for (size_t column = 0; column < std::size(kMetalness); ++column, ++index) {
      const Reflectance& r = reflectances[index % std::size(reflectances)];
      scene::Material material =
          scene::plainMaterial("odd", colors[index % std::size(colors)], kMetalness[column], kRoughness[row]);
      material.data.f0 = (r.ior - 1) * (r.ior - 1) / ((r.ior + 1) * (r.ior + 1));
      material.data.specular = r.specular;
      material.data.specularColor = r.tint;
      if (index % 6 == 1) setTexture(material, shared::kTextureNormal, 0);
      if (index % 9 == 4) setTexture(material, shared::kTextureMetallicRoughness, 1);
      if (index % 13 == 5) material.data.emissive = vec3(0.1f, 0.02f, 0.3f);
      if (index == 20) material.data.flags |= shared::kMaterialUnlit;
      scene.materials.push_back(std::move(material));
      const vec3 place(static_cast<float>(column) - 3, 2.5f - static_cast<float>(row), 0);
      builder.addInstance("sphere", builder.kRoot, 0, index, glm::translate(glm::mat4(1), place));
    }
  const auto light = [&](uint32_t type, vec3 position, vec3 direction, float intensity) {
    scene::Light& l = scene.lights.emplace_back();
    l.type = type;
    l.position = position;
    l.direction = glm::normalize(direction);
    l.color = {1, 0.9f, 0.8f};
    l.intensity = intensity * strength;
  };
  // World space: the spheres stand in the plane y = 0 and are viewed from -y.
  light(shared::kLightDirectional, {}, {0.4f, 1, -0.6f}, 1);
  light(shared::kLightDirectional, {}, {-1, 0.2f, 0.1f}, 0.6f);
  light(shared::kLightPoint, {0.5f, -1.5f, 0.5f}, {1, 0, 0}, 3);
  light(shared::kLightPoint, {-2.5f, -0.7f, -1.5f}, {1, 0, 0}, 0.8f);
  light(shared::kLightSpot, {3, -4, 2}, {-0.5f, 1, -0.4f}, 20);
  scene.lights.back().outerCone = 0.5f;
  scene.cameras.push_back(scene::frameScene(scene, 7.0f / 6));
  return std::move(scene);
}

TEST_F(DefaultLayoutTest, HoldsOddMaterialsUnderLights) {
  for (float strength : {1.0f, 30.0f})  // black paint in sunlight
    for (const char* tonemap : {"khronos", "none"}) {
      Settings settings = settingsOf(350, 300);
      settings.tonemap = choiceNamed<Tonemap>(tonemap).value();
      expectExact(oddSpheres(strength), nullptr, settings,
                  fmt::format("odd spheres, lights times {}, tonemap {}", strength, tonemap).c_str());
    }
}

TEST_F(DefaultLayoutTest, HoldsOddMaterialsUnderAnEnvironment) {
  const scene::Environment studio = scene::loadEnvironment("studio");
  scene::Scene scene = oddSpheres(0);
  scene.lights.clear();
  expectExact(scene, &studio, settingsOf(350, 300), "odd spheres in the studio");
}

TEST_F(DefaultLayoutTest, HoldsThemShadedByBlinnPhong) {
  Settings settings = settingsOf(175, 150);
  settings.shading = Shading::BlinnPhong;
  expectExact(oddSpheres(2), nullptr, settings, "odd spheres, Blinn-Phong");
}

// --- scenes and models ----------------------------------------------------------------------------------------------

TEST_F(DefaultLayoutTest, HoldsTheBuiltInScenes) {
  const scene::Environment studio = scene::loadEnvironment("studio");
  for (const char* name : {"builtin:boxes", "builtin:spheres", "builtin:hall,triangles=60k,lights=100"}) {
    const scene::Scene scene = scene::load(name);
    expectExact(scene, scene.lights.empty() ? &studio : nullptr, settingsOf(320, 180), name);
  }
}

// The studio environment plus a sun that is brighter than it.
class DefaultLayoutModelTest : public DefaultLayoutTest, public testing::WithParamInterface<std::filesystem::path> {};
TEST_P(DefaultLayoutModelTest, IsHeld) {
  if (!std::filesystem::exists(GetParam())) GTEST_SKIP() << GetParam() << " is not there: install assimp-testmodels";
  const scene::Scene scene = scene::load(GetParam().string());
  const scene::Environment studio = scene::loadEnvironment("studio");
  Settings settings = settingsOf(240, 180);
  settings.sun = SunLight{.azimuth = 0.6f, .elevation = 0.8f, .illuminance = 5};
  expectExact(scene, &studio, settings, GetParam().filename().c_str());
}

std::string nameOf(const testing::TestParamInfo<std::filesystem::path>& info) {
  std::string name = info.param.stem().string();
  std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
  return name;
}

std::vector<std::filesystem::path> testModels() {
  std::vector<std::filesystem::path> paths;
  for (const std::string& name :
       models::withReal({"punctual.glb", "textured.glb", "blended.glb"},
                        {"DamagedHelmet.glb", "Fox.glb", "CesiumMan.glb", "lights_punctual.glb"}))
    paths.push_back(models::modelPath(name));
  return paths;
}
INSTANTIATE_TEST_SUITE_P(Models, DefaultLayoutModelTest, testing::ValuesIn(testModels()), nameOf);

// A model of Debian's package assimp-testmodels.
std::filesystem::path assimpModel(const char* name) {
  return std::filesystem::path("/usr/share/assimp/models/glTF2") / name;
}
INSTANTIATE_TEST_SUITE_P(
    Assimp, DefaultLayoutModelTest,
    testing::Values(assimpModel("BoxTextured-glTF-Binary/BoxTextured.glb"),
                    assimpModel("2CylinderEngine-glTF-Binary/2CylinderEngine.glb"),
                    assimpModel("ClearCoat-glTF/ClearCoatTest.gltf"),
                    assimpModel("BoxBadNormals-glTF-Binary/BoxBadNormals.glb"),
                    assimpModel("textureTransform/TextureTransformTest.gltf"),
                    assimpModel("glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf"),
                    assimpModel("simple_skin/simple_skin.gltf")),
    nameOf);

}  // namespace
}  // namespace latelight::render::test
