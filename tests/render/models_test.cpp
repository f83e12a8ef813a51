// Every lighting technique on complete models, in the studio environment and with all kinds of lights: deferred
// techniques equal fullscreen on the same layout, and forward techniques equal the layout plain.
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>

#include "models/models.h"
#include "render/lighting/technique.h"
#include "render/outputs/outputs.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

constexpr uint32_t kModelWidth = 160, kModelHeight = 120;

// Forty point and spot lights on a spiral around the model, and one directional light. Every third light has a range.
void addLights(scene::Scene& scene) {
  const scene::Bounds bounds = scene::worldBounds(scene);
  const glm::vec3 center(bounds.center());
  const float radius = 0.6f * glm::length(glm::vec3(bounds.max - bounds.min));
  for (int i = 0; i < 40; ++i) {
    const float z = 0.95f - 0.0475f * static_cast<float>(i), around = 2.4f * static_cast<float>(i);
    const float across = std::sqrt(1 - z * z);
    scene::Light& light = scene.lights.emplace_back();
    light.type = i % 2 ? shared::kLightSpot : shared::kLightPoint;
    light.position = center + radius * glm::vec3(across * std::cos(around), across * std::sin(around), z);
    light.direction = glm::normalize(center - glm::vec3(light.position));
    light.color = {0.5f + 0.0125f * static_cast<float>(i), 0.7f, 1 - 0.02f * static_cast<float>(i)};
    light.intensity = 0.1f * radius * radius;
    light.innerCone = 0.1f;
    light.outerCone = 0.5f;
    if (i % 3 == 0) light.range = 0.9f * radius;
  }
  scene::Light& sun = scene.lights.emplace_back();
  sun.type = shared::kLightDirectional;
  sun.direction = glm::normalize(glm::vec3(-1, 2, -1));
  sun.intensity = 0.4f;
}

class ModelsTest : public RenderTest, public testing::WithParamInterface<std::string> {};

TEST_P(ModelsTest, LooksTheSameByEveryTechnique) {
  scene::Scene scene = scene::load(models::modelPath(GetParam()));
  addLights(scene);
  const scene::Environment studio = scene::loadEnvironment("studio");
  // Drawn techniques sample textures in fragment shaders, as the geometry pass does with the code paths for GPUs. On a
  // CPU device, materials may be evaluated in compute (visibility/resolve.h).
  Renderer own(device(), scene, &studio), drawn(gpuPaths(), scene, &studio);
  const scene::Camera camera = cameraOf(scene, kModelWidth, kModelHeight);
  const auto picture = [&](Renderer& renderer, const std::string& layout, const std::string& lighting) {
    Settings settings{.width = kModelWidth,
                      .height = kModelHeight,
                      .layout = &findLayout(layout),
                      .lighting = &findTechnique(lighting)};
    return std::move(renderer.render({&camera, 1}, settings).front().display);
  };
  const std::vector<uint8_t> thin = picture(own, "thin", "fullscreen"), plain = picture(drawn, "plain", "fullscreen");
  size_t bright = 0;
  for (size_t i = 0; i < plain.size(); i += 4) bright += plain[i] > 60;
  EXPECT_GT(bright, plain.size() / 4 / 50);  // the image is not nearly black
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    const std::vector<uint8_t>& expected = technique.forward ? plain : thin;
    const std::vector<uint8_t> got = picture(own, "thin", technique.name);
    ASSERT_EQ(got.size(), expected.size());
    int worst = 0;
    for (size_t i = 0; i < got.size(); ++i) worst = std::max(worst, std::abs(got[i] - expected[i]));
    EXPECT_LE(worst, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, ModelsTest,
                         testing::ValuesIn(models::withReal({"punctual.glb", "blended.glb", "textured.glb"},
                                                            {"DamagedHelmet.glb", "Fox.glb", "CesiumMan.glb",
                                                             "lights_punctual.glb"})),
                         caseName);

class DataOfModelsTest : public RenderTest {};

// Each output rendered alone, from a scene loaded with only the textures that it requires, equals the same output
// rendered together with all others.
TEST_F(DataOfModelsTest, RequireOnlyTheirTextures) {
  using output::Aov;
  const std::vector<Aov> all{Aov::Depth,     Aov::Normal,   Aov::GeoNormal, Aov::Position, Aov::Albedo, Aov::Metallic,
                             Aov::Roughness, Aov::Emissive, Aov::Ao,        Aov::Id,       Aov::Uv};
  for (const char* model : {"textured.glb", "blended.glb"}) {  // both have an alpha mask
    const std::string path = models::modelPath(model).string();
    const scene::Scene whole = scene::load(path);
    const scene::Camera camera = cameraOf(whole, kModelWidth, kModelHeight);
    const output::FrameOutput expected = renderOne(device(), whole, camera, settingsOf(kModelWidth, kModelHeight, all));
    for (const Aov aov : all) {
      SCOPED_TRACE(fmt::format("{} of {}", output::info(aov).name, model));
      const Settings settings = settingsOf(kModelWidth, kModelHeight, {aov});
      const scene::Scene sparse = scene::load(path, {.textureSlots = textureSlots(settings)});
      EXPECT_LT(sparse.textures.size(), whole.textures.size());
      const output::FrameOutput got = renderOne(device(), sparse, camera, settings);
      EXPECT_EQ(imageOf(got, aov).values, imageOf(expected, aov).values);
      EXPECT_EQ(imageOf(got, aov).ids, imageOf(expected, aov).ids);
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
