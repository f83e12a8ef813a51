// --raster auto selects rays for worlds of far more triangles than samples on CPU devices, and only there.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "render/submit/raster_choice.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

class RasterChoiceTest : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (!device().isCpu()) GTEST_SKIP() << "skipped: GPUs rasterize worlds unless rays are asked for";
  }

  static Settings automatic(uint32_t side) {
    Settings settings = settingsOf(side, side, {output::Aov::Depth});
    settings.raster = Raster::Auto;
    return settings;
  }

  static bool traces(const scene::Scene& scene, const Settings& settings, RasterUse use = RasterUse::Worlds) {
    return chooseRaster(device(), settings, scene, use).raster == Raster::Rays;
  }
};

TEST_F(RasterChoiceTest, ComparesTrianglesWithSamples) {
  const scene::Scene scene = scene::load("builtin:spheres");
  const auto side = static_cast<uint32_t>(std::sqrt(double(scene.triangleCount()) / 30));
  EXPECT_TRUE(traces(scene, automatic(side)));
  EXPECT_FALSE(traces(scene, automatic(side + 1)));
  Settings samples = automatic(side);
  samples.aa.samples = 4;
  samples.lighting = &findTechnique("clustered");
  EXPECT_FALSE(traces(scene, samples));
  samples.width = samples.height = side / 2;
  EXPECT_TRUE(traces(scene, samples));
}

TEST_F(RasterChoiceTest, KeepsHierarchiesOverCalls) {
  const scene::Scene scene = scene::load("builtin:spheres");
  EXPECT_TRUE(traces(scene, automatic(16)));
  EXPECT_FALSE(traces(scene, automatic(16), RasterUse::Image));
  EXPECT_FALSE(traces(scene, automatic(16), RasterUse::DeformedWorlds));
}

TEST_F(RasterChoiceTest, RasterizesWhatRaysDoNotServe) {
  Settings forward = automatic(16);
  forward.display = true;
  forward.lighting = &findTechnique("forward");
  const scene::Scene spheres = scene::load("builtin:spheres");
  EXPECT_FALSE(traces(spheres, forward));

  scene::SceneBuilder builder("many squares");
  builder.scene.meshes.push_back(squareMesh());
  builder.scene.materials.push_back(scene::plainMaterial("plain", glm::vec3(0.5f), 0, 1));
  for (uint32_t i = 0; i < 1000; ++i)
    builder.addInstance("square" + std::to_string(i), builder.kRoot, 0, 0, glm::mat4(1));
  const scene::Scene scene = std::move(builder.scene);
  EXPECT_FALSE(traces(scene, automatic(4)));
}

TEST_F(RasterChoiceTest, FollowsARequest) {
  Settings settings = automatic(16);
  settings.raster = Raster::Compute;
  EXPECT_FALSE(traces(scene::load("builtin:spheres"), settings));
}

}  // namespace
}  // namespace latelight::render::test
