// Glass with several samples per pixel: each fragment covers the unoccluded samples of its triangle, so that edges are
// smooth with every method.
#include <fmt/core.h>

#include <cmath>

#include "long_tests.h"
#include "shared/samples.h"
#include "transparency/scenes.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kSide = 16;  // pixels, of a picture 2 units wide

class GlassSamples : public RenderTest, public testing::WithParamInterface<uint32_t> {
 protected:
  static Settings settings(uint32_t size, const char* method) {
    Settings settings = settingsOf(size, size, {Aov::Color});
    settings.raster = Raster::Compute;
    settings.aa.samples = GetParam();
    settings.transparency = choiceNamed<TransparencyMethod>(method).value();
    return settings;
  }
  static std::vector<float> color(const scene::Scene& scene, const Settings& settings) {
    return imageOf(renderOne(device(), scene, frontCamera(), settings), Aov::Color).values;
  }
  // The share of a pixel's samples between two positions along x.
  static float shareBetween(double low, double high) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < GetParam(); ++i) {
      const double x = shared::samplePlace(GetParam(), i).x;
      count += x > low && x < high;
    }
    return static_cast<float>(count) / static_cast<float>(GetParam());
  }
};

INSTANTIATE_TEST_SUITE_P(Samples, GlassSamples, testing::Values(2, 16),
                         [](const auto& info) { return std::to_string(info.param); });

float unitsAt(double pixel) {
  return static_cast<float>(pixel * 2 / kSide - 1);
}

// Glass from pixel 3.2 on, and a wall in front of it from pixel 3.7 on. Between them only the glass is visible, over
// the pixel's mean of the wall and the background.
TEST_P(GlassSamples, CoverWhatTheyCoverAndNothingHides) {
  const vec4 glass(0.8f, 0.4f, 0.2f, 0.6f);
  const vec3 wall(0.1f, 0.5f, 0.9f);
  Stack stack;
  const auto add = [&](uint32_t material, double from, float z) {
    const float left = unitsAt(from), half = (1.1f - left) / 2;
    stack.square(material, {left + half, 0, z}, {half, 1.1f});
  };
  add(stack.glass(glass), 3.2, 0);
  add(stack.solid(wall), 3.7, 1);
  const float share = shareBetween(0.2, 0.7), behind = shareBetween(0.7, 1);
  const vec4 mean = vec4(wall, 1) * behind;
  const vec4 expected = mean + (vec4(vec3(glass) * glass.a, glass.a) - mean * glass.a) * share;
  for (const char* method : {"exact", "sorted", "weighted"}) {
    SCOPED_TRACE(method);
    const std::vector<float> picture = color(stack.scene, settings(kSide, method));
    for (uint32_t y = 0; y < kSide; ++y) {
      for (int c = 0; c < 4; ++c) {
        ASSERT_EQ(picture[4 * (y * kSide + 2) + c], 0) << y;
        ASSERT_NEAR(picture[4 * (y * kSide + 3) + c], expected[c], 2e-3f) << y;
        ASSERT_NEAR(picture[4 * (y * kSide + 4) + c], vec4(wall, 1)[c], 2e-3f) << y;
      }
    }
  }
}

// Spheres of flat glass: the more samples, the closer the picture is to that of 256 samples.
scene::Scene glassSpheres() {
  Stack stack;
  stack.scene.meshes.push_back(sphereMesh(0.5f));
  for (const float x : {-0.35f, 0.0f, 0.3f}) {
    const uint32_t material = stack.glass({0.9f, 0.5f + x, 0.3f - x, 0.5f});
    stack.builder.addInstance("sphere", stack.builder.kRoot, 1, material,
                              glm::translate(glm::mat4(1), vec3(x, 0.5f * x, -x)));
  }
  return std::move(stack.scene);
}

TEST_P(GlassSamples, MakeRimsSmooth) {
  if (GetParam() > 2) LATELIGHT_SKIP_UNLESS_ALL();
  const scene::Scene scene = glassSpheres();
  for (const char* method : {"exact", "sorted", "weighted"}) {
    Settings wanted = settings(48, method);
    const std::vector<float> some = color(scene, wanted);
    wanted.aa.samples = 1;
    const std::vector<float> one = color(scene, wanted);
    wanted.aa.superSampling = 8;
    const std::vector<float> many = color(scene, wanted);
    double before = 0, after = 0;
    for (size_t i = 0; i < many.size(); ++i) {
      before += std::pow(one[i] - many[i], 2);
      after += std::pow(some[i] - many[i], 2);
    }
    fmt::print("{}, {} samples: {:.3f} of the squared error with one\n", method, GetParam(), after / before);
    EXPECT_LT(after, before / GetParam() * 1.5) << method;
  }
}

TEST_P(GlassSamples, ViewsTogetherAreViewsAloneInEveryRun) {
  const scene::Scene scene = glassSpheres();
  Renderer renderer(device(), scene, nullptr);
  const std::vector<scene::Camera> cameras{frontCamera(), frontPerspective(0.5f, 3), frontCamera(0.4f)};
  for (const char* method : {"exact", "sorted", "weighted"}) {
    const Settings wanted = settings(40, method);
    const auto together = renderer.render(cameras, wanted), again = renderer.render(cameras, wanted);
    for (size_t i = 0; i < cameras.size(); ++i) {
      const auto alone = renderer.render({&cameras[i], 1}, wanted);
      EXPECT_EQ(imageOf(together[i], Aov::Color).values, imageOf(alone.front(), Aov::Color).values) << method;
      EXPECT_EQ(imageOf(together[i], Aov::Color).values, imageOf(again[i], Aov::Color).values) << method;
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
