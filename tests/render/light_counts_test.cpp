// The number of lights that each pixel evaluated and the number that contributed, with every technique, on a square
// with known lights.
#include <fmt/core.h>

#include <algorithm>

#include "render/lighting/technique.h"
#include "render/support.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kSize = 64;

// The square fills the central half of the image in both directions. World space: it lies in the plane y = 0 and faces
// -y.
scene::Scene litSquare() {
  scene::SceneBuilder builder("square");
  scene::Scene& scene = builder.scene;
  scene.meshes.push_back(squareMesh());
  scene.materials.push_back(scene::plainMaterial("white", glm::vec3(1), 0, 0.5f));
  builder.addInstance("square", builder.kRoot, 0, 0, glm::mat4(1));
  const auto light = [&](uint32_t type, glm::vec3 position, glm::vec3 direction, std::optional<float> range) {
    scene::Light& l = scene.lights.emplace_back();
    l.type = type;
    l.position = position;
    l.direction = direction;
    l.intensity = 2;
    l.range = range;
    l.innerCone = 0.1f;
    l.outerCone = 0.2f;
  };
  light(shared::kLightDirectional, {}, {0, 1, 0}, {});       // lights the whole square
  light(shared::kLightDirectional, {}, {0, -1, 0}, {});      // from behind: lights nothing
  light(shared::kLightPoint, {0, -0.3f, 0}, {}, 0.5f);       // lights points within 0.4 m of the center
  light(shared::kLightSpot, {-0.5f, -1, 0}, {0, 1, 0}, {});  // lights points within tan(0.2) m of (-0.5, 0)
  light(shared::kLightPoint, {0, -50, 0}, {}, 10.0f);        // too far away
  return std::move(scene);
}

TEST_F(RenderTest, LightsAreCountedByEveryTechnique) {
  const scene::Scene scene = litSquare();
  Renderer renderer(device(), scene, nullptr);
  Settings settings = settingsOf(kSize, kSize, {Aov::LightsTested, Aov::LightsUsed});
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    settings.lighting = &technique;
    const scene::Camera camera = frontCamera(2);
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
    size_t inPoint = 0, inSpot = 0;
    for (size_t pixel = 0; pixel < kSize * kSize; ++pixel) {
      const float tested = imageOf(frame, Aov::LightsTested).values[pixel];
      const float used = imageOf(frame, Aov::LightsUsed).values[pixel];
      const double x = (static_cast<double>(pixel % kSize) + 0.5) / kSize * 4 - 2;
      const double z = 2 - (static_cast<double>(pixel / kSize) + 0.5) / kSize * 4;
      if (std::abs(x) > 1 || std::abs(z) > 1) {
        ASSERT_EQ(tested, 0) << pixel;
        ASSERT_EQ(used, 0) << pixel;
        continue;
      }
      const double toPoint = std::hypot(x, z), toSpot = std::hypot(x + 0.5, z);
      if (std::abs(toPoint - 0.4) < 0.01 || std::abs(toSpot - std::tan(0.2)) < 0.01) continue;  // edges
      inPoint += toPoint < 0.4;
      inSpot += toSpot < std::tan(0.2);
      ASSERT_EQ(used, 1 + (toPoint < 0.4) + (toSpot < std::tan(0.2))) << pixel;
      ASSERT_GE(tested, used) << pixel;
      ASSERT_LE(tested, scene.lights.size()) << pixel;
    }
    EXPECT_GT(inPoint, 50u);
    EXPECT_GT(inSpot, 10u);
  }
}

bool listsLights(const RenderStatistics& statistics) {
  const auto isListing = [](const graph::PassTime& pass) { return pass.name == "light lists"; };
  return std::ranges::any_of(statistics.passTimes, isListing);
}

// Few lights are in no lists, unless they are counted.
TEST_F(RenderTest, FewLightsAreListedOnlyToCountThem) {
  scene::Scene scene = litSquare();
  for (scene::Light& light : scene.lights) light.castShadow = true;
  const scene::Camera camera = frontCamera(2);
  for (const char* technique : {"tiled", "clustered"})
    for (const Raster raster : {Raster::Hardware, Raster::Compute})
      for (const ShadowFormat shadows : {ShadowFormat::None, ShadowFormat::D32, ShadowFormat::Rays}) {
        SCOPED_TRACE(fmt::format("{}, {}, shadows {}", technique, nameOf(raster), nameOf(shadows)));
        Renderer renderer(device(), scene, nullptr);
        Settings settings = settingsOf(kSize, kSize, {Aov::Color});
        settings.lighting = &findTechnique(technique);
        settings.raster = raster;
        settings.shadows = shadows;
        const RenderResult few = renderer.submit({&camera, 1}, settings).take();
        settings.aovs.push_back(Aov::LightsTested);
        const RenderResult counted = renderer.submit({&camera, 1}, settings).take();
        EXPECT_FALSE(listsLights(few.statistics));
        EXPECT_EQ(listsLights(counted.statistics), !counted.statistics.passTimes.empty());  // without timestamps
        const std::vector<float>& color = imageOf(few.frames.front(), Aov::Color).values;
        EXPECT_TRUE(color == imageOf(counted.frames.front(), Aov::Color).values);
        EXPECT_TRUE(std::ranges::any_of(color, [](float value) { return value > 1.5f; }));
      }
}

// The reference technique culls no lights.
TEST_F(RenderTest, FullscreenTestsEveryLight) {
  const scene::Scene scene = litSquare();
  const output::FrameOutput frame =
      renderOne(device(), scene, frontCamera(1), settingsOf(kSize, kSize, {Aov::LightsTested}));
  for (float tested : imageOf(frame, Aov::LightsTested).values) ASSERT_EQ(tested, scene.lights.size());
}

}  // namespace
}  // namespace latelight::render::test
