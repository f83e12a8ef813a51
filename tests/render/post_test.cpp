// Post-processing: FXAA against supersampling, fog against integration, disabled and combined effects.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using output::Aov;

class PostTest : public RenderTest {
 protected:
  static std::vector<uint8_t> shown(Renderer& renderer, const scene::Camera& camera, Settings settings) {
    settings.display = true;
    return renderer.render({&camera, 1}, settings).front().display;
  }
};

// --- FXAA -----------------------------------------------------------------------------------------------------------

struct Edges {
  double without = 0, with = 0;  // squared difference from supersampling at pixels off by >= 16 codes without FXAA
  size_t pixels = 0, changedInFlat = 0, flat = 0;
};

Edges compareEdges(const std::vector<uint8_t>& plain, const std::vector<uint8_t>& smooth,
                   const std::vector<uint8_t>& reference, uint32_t width) {
  Edges e;
  const size_t pixels = plain.size() / 4, height = pixels / width;
  for (size_t i = 0; i < pixels; ++i) {
    double before = 0, after = 0;
    for (size_t c = 4 * i; c < 4 * i + 4; ++c) {
      before += std::pow(plain[c] - reference[c], 2);
      after += std::pow(smooth[c] - reference[c], 2);
    }
    if (before > 4 * 16 * 16) e.without += before, e.with += after, ++e.pixels;
    const size_t x = i % width, y = i / width;
    bool flat = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
    for (size_t n : {i - 1, i + 1, i - width, i + width})
      flat = flat && std::equal(&plain[4 * i], &plain[4 * i] + 4, &plain[4 * n]);
    if (!flat) continue;
    ++e.flat;
    e.changedInFlat += !std::equal(&plain[4 * i], &plain[4 * i] + 4, &smooth[4 * i]);
  }
  return e;
}

TEST_F(PostTest, FxaaBringsEdgesNearerToSuperSampling) {
  struct Case {
    const char* name;
    const scene::Scene& scene;
    double factor;
    size_t minFlat;
  };
  const scene::Scene boxes = scene::load("builtin:boxes");
  const Case cases[] = {{"boxes on a transparent background", boxes, 1.6, 10000}, {"hall", hall(), 2.0, 30}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Renderer renderer(device(), c.scene, nullptr);
    Settings settings = settingsOf(320, 180);
    const scene::Camera camera = c.scene.cameras.front();
    const auto plain = shown(renderer, camera, settings);
    settings.aa.fxaa = true;
    const auto smooth = shown(renderer, camera, settings);
    settings.aa.fxaa = false;
    settings.aa.superSampling = 4;
    const Edges e = compareEdges(plain, smooth, shown(renderer, camera, settings), 320);
    fmt::print("{}: {} edge pixels, mean square {:.0f} without, {:.0f} with FXAA: {:.2f} times less\n", c.name,
               e.pixels, e.without / double(e.pixels), e.with / double(e.pixels), e.without / e.with);
    EXPECT_GT(e.pixels, 300u);
    EXPECT_GT(e.without, c.factor * e.with);
    EXPECT_GT(e.flat, c.minFlat);
    EXPECT_EQ(e.changedInFlat, 0u);
  }
}

// --- fog ------------------------------------------------------------------------------------------------------------

// The transmittance between two points, by Simpson's rule on the density; in glTF's frame, Y up.
double transmittance(const Settings& s, dvec3 from, dvec3 to) {
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double y = glm::mix(from, to, double(i) / kSteps).y;
    const double density = s.fogDensity * (s.fogHeight > 0 ? std::exp(-(y - s.fogBase) / s.fogHeight) : 1.0);
    sum += density * (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2);
  }
  return std::exp(-sum * glm::length(to - from) / kSteps / 3);
}

TEST_F(PostTest, FogIsTheIntegralOfItsDensity) {
  const scene::Scene scene = scene::load("builtin:boxes");
  scene::Camera perspective = scene.cameras.front(), orthographic = perspective;
  perspective.principal = {0.2f, -0.9f};  // looks up
  orthographic.orthographic = true;
  orthographic.yHalf = 12, orthographic.farClip = 100;
  Renderer renderer(device(), scene, nullptr);
  for (const scene::Camera& camera : {perspective, orthographic})
    for (float height : {0.0f, 1.5f}) {
      SCOPED_TRACE(fmt::format("orthographic {}, height {}", camera.orthographic, height));
      Settings settings = settingsOf(96, 64, {Aov::Color, Aov::Position, Aov::Distance});
      const auto before = renderer.render({&camera, 1}, settings).front();
      settings.fogDensity = 0.08f, settings.fogColor = {0.3f, 0.5f, 0.9f};
      settings.fogHeight = height, settings.fogBase = 0.5f;
      const auto after = renderer.render({&camera, 1}, settings).front();
      EXPECT_EQ(imageOf(before, Aov::Position).values, imageOf(after, Aov::Position).values);
      const glm::mat4 pose = scene::toGltfFromWorld() * camera.toWorld;
      size_t open = 0, covered = 0;
      for (size_t i = 0; i < 96 * 64; ++i) {
        const float *b = &imageOf(before, Aov::Color).values[4 * i], *a = &imageOf(after, Aov::Color).values[4 * i];
        if (b[3] == 0) {
          ++open;
          EXPECT_TRUE(height > 0 || a[3] > 0.999f);  // uniform fog is unbounded
          for (int c = 0; c < 3; ++c) ASSERT_NEAR(a[c], a[3] * settings.fogColor[c], 1e-3);
          continue;
        }
        ++covered;
        const dvec3 p(vec3At(imageOf(after, Aov::Position), i));
        const dvec3 from = camera.orthographic
                               ? p - double{imageOf(after, Aov::Distance).values[i]} * glm::normalize(dvec3(pose[1]))
                               : dvec3(pose[3]);
        const double t = transmittance(settings, from, p);
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(a[c], b[c] * t + settings.fogColor[c] * (1 - t), 2e-3 * (1 + b[c])) << i;
        ASSERT_EQ(a[3], 1.0f);
      }
      EXPECT_GT(covered, 1000u);
      EXPECT_GT(open, 20u);
    }
}

// --- all effects ----------------------------------------------------------------------------------------------------

using Change = std::function<void(Settings&)>;

TEST_F(PostTest, DisabledEffectsChangeNothingAndEnabledOnesDo) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  Settings plain = settingsOf(80, 45);
  plain.lighting = &findTechnique("tiled");
  const auto without = shown(renderer, scene.cameras.front(), plain);
  const Change off[] = {[](Settings& s) { s.bloom = 0, s.bloomRadius = 0.2f, s.bloomThreshold = 3; },
                        [](Settings& s) { s.fogDensity = 0, s.fogHeight = 4; },
                        [](Settings& s) { s.aoRadius = 3, s.aoStrength = 5; },
                        [](Settings& s) {
                          s.ambientOcclusion = AmbientOcclusion::Gtao;
                          s.aoRadius = 1e-20f, s.aoStrength = 5;
                        }};
  for (const Change& change : off) {
    Settings settings = plain;
    change(settings);
    EXPECT_EQ(shown(renderer, scene.cameras.front(), settings), without);
  }
  const Change on[] = {[](Settings& s) { s.bloom = 0.2f; }, [](Settings& s) { s.fogDensity = 0.1f; },
                       [](Settings& s) { s.ambientOcclusion = AmbientOcclusion::Gtao; },
                       [](Settings& s) { s.aa.fxaa = true; }};
  Settings everything = plain;
  for (const Change& change : on) {
    Settings settings = plain;
    change(settings);
    change(everything);
    EXPECT_NE(shown(renderer, scene.cameras.front(), settings), without);
  }
  for (uint32_t samples : {1u, 2u})
    for (auto [width, height] : {std::pair{80u, 45u}, {1u, 1u}, {3u, 2u}}) {
      everything.aa.superSampling = samples;
      everything.width = width, everything.height = height;
      const auto once = shown(renderer, scene.cameras.front(), everything);
      EXPECT_EQ(once, shown(renderer, scene.cameras.front(), everything));
    }
}

TEST_F(PostTest, InvalidValuesAreReportedInASentence) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Renderer renderer(device(), scene, nullptr);
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  const std::pair<const char*, Change> wrong[] = {
      {"--ao-radius takes a number above 0 meters", [](Settings& s) { s.aoRadius = 0; }},
      {"--ao-radius takes a number above 0 meters", [](Settings& s) { s.aoRadius = -1; }},
      {"--ao-radius takes a number above 0 meters", [](Settings& s) { s.aoRadius = kNan; }},
      {"--ao-radius takes a number above 0 meters", [](Settings& s) { s.aoRadius = kInf; }},
      {"--ao-strength", [](Settings& s) { s.aoStrength = kNan; }},
      {"--bloom takes a number from 0 to 1", [](Settings& s) { s.bloom = -0.1f; }},
      {"--bloom takes a number from 0 to 1", [](Settings& s) { s.bloom = kNan; }},
      {"--bloom-radius", [](Settings& s) { s.bloomRadius = 1.5f; }},
      {"--bloom-threshold", [](Settings& s) { s.bloomThreshold = -1; }},
      {"--fog takes a number from 0 to 1000000 1/m", [](Settings& s) { s.fogDensity = kInf; }},
      {"--fog-color", [](Settings& s) { s.fogColor.y = kNan; }},
      {"--fog-height", [](Settings& s) { s.fogHeight = -1; }},
      {"--fog-base", [](Settings& s) { s.fogBase = kNan; }}};
  for (const auto& [says, change] : wrong) {
    Settings settings = settingsOf(8, 8);
    change(settings);
    try {
      shown(renderer, scene.cameras.front(), settings);
      ADD_FAILURE() << says;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
