// GPUs trace rays in spans of pixels if there are many views (render/base/pixel_span.h). On a CPU device, the code
// paths for GPUs do so for images of any size, and produce the same bytes as those for CPUs, which do not.
#include "render/base/pixel_span.h"

#include <fmt/core.h>

#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using output::Aov;

// Without the scene's own lights.
scene::Scene boxes() {
  scene::Scene scene = scene::load("builtin:boxes");
  scene.lights.clear();
  return scene;
}

void addLamp(scene::Scene& scene, const glm::vec3& position, float radius) {
  scene::Light& light = scene.lights.emplace_back();
  light.type = shared::kLightPoint;
  light.position = position;
  light.size = radius;
  light.intensity = 30;
}

class PixelSpans : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (!device().isCpu()) GTEST_SKIP() << "a GPU has one code path";
  }

  // Renders two views, of which one sees little of the scene.
  static void compare(const scene::Scene& scene, Settings settings) {
    scene::Camera camera = cameraOf(scene, settings.width, settings.height);
    std::vector<scene::Camera> cameras = {camera, camera};
    cameras[1].toWorld = glm::translate(cameras[1].toWorld, glm::dvec3(0.9 * settings.width / settings.height, 0, 0));
    for (const Raster raster : {Raster::Compute, Raster::Rays}) {
      SCOPED_TRACE(fmt::format("{}x{}, raster {}", settings.width, settings.height, static_cast<int>(raster)));
      settings.raster = raster;
      Renderer pixels(device(), scene, nullptr), spans(gpuPaths(), scene, nullptr);
      const std::vector<output::FrameOutput> expected = pixels.render(cameras, settings);
      const std::vector<output::FrameOutput> found = spans.render(cameras, settings);
      for (size_t i = 0; i < cameras.size(); ++i) {
        EXPECT_TRUE(found[i].display == expected[i].display) << i;
        EXPECT_TRUE(imageOf(found[i], Aov::Color).values == imageOf(expected[i], Aov::Color).values) << i;
        EXPECT_TRUE(imageOf(found[i], Aov::Triangle).ids == imageOf(expected[i], Aov::Triangle).ids) << i;
      }
    }
  }
  static Settings settingsFor(uint32_t width, uint32_t height) {
    Settings settings = settingsOf(width, height, {Aov::Color, Aov::Triangle});
    settings.display = true;
    settings.lighting = &findTechnique("clustered");
    settings.shadows = ShadowFormat::Rays;
    return settings;
  }
};

// Sizes that spans and blocks do not divide, less than a block, and several spans.
TEST_F(PixelSpans, ShadowsOfTheSunAreTheSame) {
  for (const auto& [width, height] : {std::pair{150u, 70u}, {64u, 64u}, {5u, 3u}}) {
    Settings settings = settingsFor(width, height);
    settings.sun = SunLight{.azimuth = 0.8f, .elevation = 0.5f};
    compare(boxes(), settings);
  }
}

// A light with a radius has a ray to a point of its disk.
TEST_F(PixelSpans, ShadowsOfALampAreTheSame) {
  scene::Scene scene = boxes();
  addLamp(scene, {3, 4, 2}, 0.3f);
  compare(scene, settingsFor(150, 70));
}

TEST_F(PixelSpans, ShadowsOfSeveralLightsAreTheSame) {
  scene::Scene scene = boxes();
  for (const float x : {-3.0f, 0.5f, 3.0f}) addLamp(scene, {x, 4, 2}, 0);
  compare(scene, settingsFor(150, 70));
}

TEST_F(PixelSpans, AreForManyViewsOnGpus) {
  EXPECT_EQ(spanSide(device(), {64, 64, 65536}), 1u);
  EXPECT_EQ(spanSide(gpuPaths(), {5, 3, 1}), kSpanSide);
}

}  // namespace
}  // namespace latelight::render::test
