// Temporal antialiasing compared with supersampling of the same frames: it is better than no antialiasing, close to
// supersampling, and does not flicker.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "models/models.h"
#include "motion/files.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using Picture = std::vector<uint8_t>;

struct Sequence {
  const scene::Scene& scene;
  std::string animation;
  double start;
  uint32_t frames;
};

// The root mean square difference of two pictures, in levels, over the pixels that are covered in either.
double difference(const Picture& a, const Picture& b) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < a.size(); i += 4) {
    if (a[i + 3] == 0 && b[i + 3] == 0) continue;
    for (size_t c = 0; c < 4; ++c)
      sum += std::pow(
          double(a[i + c]) * (c < 3 ? a[i + 3] / 255.0 : 1) - double(b[i + c]) * (c < 3 ? b[i + 3] / 255.0 : 1), 2);
    count += 4;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

// The largest difference of each pixel's channels, in levels.
std::vector<int> pixelDifferences(const Picture& a, const Picture& b) {
  std::vector<int> differences(a.size() / 4);
  for (size_t i = 0; i < a.size(); ++i)
    differences[i / 4] = std::max(differences[i / 4], std::abs(int(a[i]) - int(b[i])));
  return differences;
}

class TemporalTest : public RenderTest {
 protected:
  static constexpr uint32_t kWidth = 144, kHeight = 108;

  static std::vector<Picture> render(const Sequence& sequence, bool temporal, uint32_t superSampling,
                                     const std::string& layout = "thin") {
    const scene::Environment environment = constantEnvironment();
    return render(sequence, temporal, superSampling, layout, &environment);
  }

  static std::vector<Picture> render(const Sequence& sequence, bool temporal, uint32_t superSampling,
                                     const std::string& layout, const scene::Environment* environment) {
    Settings settings = settingsOf(kWidth, kHeight);
    settings.display = true;
    settings.aa.temporal = temporal;
    settings.aa.superSampling = superSampling;
    settings.layout = &findLayout(layout);
    Renderer renderer(device(), sequence.scene, environment);
    const scene::Camera camera = cameraOf(sequence.scene, kWidth, kHeight);
    const scene::Playback playback = scene::choosePlayback(sequence.scene, sequence.animation, true);
    std::vector<Picture> pictures;
    for (uint32_t i = 0; i < sequence.frames; ++i) {
      const auto pose = [&](double frame) {
        return scene::poseAt(sequence.scene, playback, sequence.start + frame / 24);
      };
      const SceneState moment{.poses = {pose(i - 1.0), pose(i), pose(i + 1.0)}, .continues = i > 0};
      pictures.push_back(std::move(renderer.render({&camera, 1}, settings, moment).front().display));
    }
    return pictures;
  }

  // With temporal antialiasing, the sequence stays within `most` levels of 16 samples per pixel, and is `factor` times
  // closer to it than one sample.
  static void expectNear(const Sequence& sequence, double most, double factor) {
    const auto exact = render(sequence, false, 4), none = render(sequence, false, 1),
               temporal = render(sequence, true, 1);
    double worst = 0, total = 0, totalNone = 0;
    for (uint32_t i = 0; i < sequence.frames; ++i) {
      worst = std::max(worst, difference(temporal[i], exact[i]));
      total += difference(temporal[i], exact[i]);
      totalNone += difference(none[i], exact[i]);
    }
    fmt::print("{}: {:.2f} levels from 16 samples, at worst {:.2f}; without {:.2f}\n", sequence.scene.name,
               total / sequence.frames, worst, totalNone / sequence.frames);
    EXPECT_LE(worst, most);
    EXPECT_LE(total * factor, totalNone);
  }
};

TEST_F(TemporalTest, SkinnedModelsMoveNearSuperSampling) {
  for (const std::string& name : models::withReal({"skinned.glb"}, {"Fox.glb"})) {
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    name == "Fox.glb" ? expectNear({scene, "Walk", 0.1, 8}, 22, 1.2) : expectNear({scene, "bend", 0.1, 8}, 20, 1.15);
  }
}

TEST_F(TemporalTest, BoxRollsNearSuperSampling) {
  const scene::Scene scene = movingBox().load();
  expectNear({scene, "", 0.2, 8}, 12, 2);
}

// A single picture is the mean of its samples.
TEST_F(TemporalTest, StillPicturesConverge) {
  const scene::Scene scene = movingBox().load();
  expectNear({scene, "", 0.3, 1}, 4, 4);
}

// If nothing moves, frames differ by at most one sample of many, whose root mean square is small under uniform light.
TEST_F(TemporalTest, StandingScenesDontFlicker) {
  const std::vector<Picture> pictures = render({hall(), "", 0, 10}, true, 1);
  const std::vector<Picture> once = render({hall(), "", 0, 1}, false, 1);
  double worst = 0;
  for (size_t i = 1; i < pictures.size(); ++i) worst = std::max(worst, difference(pictures[i], pictures[i - 1]));
  fmt::print("hall: frames {:.3f} levels apart at most; without, from the first {:.2f}\n", worst,
             difference(once[0], pictures[0]));
  EXPECT_LE(worst, 1.2);
  EXPECT_GT(difference(once[0], pictures[0]), 3) << "there is nothing that could flicker";
}

// Highlights that are smaller than a pixel flicker within the limits that docs/taa.md states.
TEST_F(TemporalTest, HighlightsFlickerInFewPixels) {
  const std::vector<Picture> pictures = render({hall(), "", 0, 10}, true, 1, "compact", nullptr);
  double worst = 0;
  std::ptrdiff_t flickering = 0;
  int largest = 0;
  for (size_t i = 1; i < pictures.size(); ++i) {
    const std::vector<int> differences = pixelDifferences(pictures[i], pictures[i - 1]);
    worst = std::max(worst, difference(pictures[i], pictures[i - 1]));
    flickering = std::max(flickering, std::ranges::count_if(differences, [](int levels) { return levels > 8; }));
    largest = std::max(largest, std::ranges::max(differences));
  }
  const double share = static_cast<double>(flickering) / (kWidth * kHeight);
  fmt::print("hall with its lights: frames {:.2f} levels apart at most, {:.2f} % of pixels above 8 levels, up to {}\n",
             worst, 100 * share, largest);
  EXPECT_LE(worst, 1.7);
  EXPECT_LE(share, 0.01);
  EXPECT_LE(largest, 90);
  EXPECT_GT(largest, 16) << "frames differ less than the page states";
}

// A surface that leaves a pixel leaves no ghost: where a picture without history is uniform for three pixels around,
// one with history is equal.
TEST_F(TemporalTest, NoGhostsStay) {
  const scene::Scene scene = movingBox().load();
  const Picture last = render({scene, "", 0.2, 8}, true, 1).back();
  const Picture fresh = render({scene, "", 0.2 + 7 / 24.0, 1}, true, 1).back();
  const auto apart = [](const Picture& a, size_t i, const Picture& b, size_t j) {
    int most = 0;
    for (size_t c = 0; c < 4; ++c)
      most = std::max(most, std::abs(int(a[4 * i + c]) * a[4 * i + 3] - int(b[4 * j + c]) * b[4 * j + 3]) / 255);
    return most;
  };
  size_t even = 0;
  for (size_t y = 3; y + 3 < kHeight; ++y)
    for (size_t x = 3; x + 3 < kWidth; ++x) {
      const size_t pixel = y * kWidth + x;
      int around = 0;
      for (size_t k = 0; k < 49; ++k)
        around = std::max(around, apart(fresh, pixel, fresh, (y + k / 7 - 3) * kWidth + x + k % 7 - 3));
      if (around > 3) continue;
      ++even;
      ASSERT_LE(apart(last, pixel, fresh, pixel), 4) << x << ", " << y;
    }
  EXPECT_GT(even, size_t{kWidth} * kHeight / 2);
}

// The radiance of a surface that emits light without any other light, times the exposures of two views.
TEST_F(TemporalTest, ExposuresChangeAtOnce) {
  scene::SceneBuilder builder("glowing");
  builder.scene.meshes.push_back(squareMesh());
  builder.scene.materials.push_back(scene::plainMaterial("glow", glm::vec3(0), 0, 1));
  builder.scene.materials.back().data.specular = 0;
  builder.scene.materials.back().data.emissive = glm::vec3(0.5f);
  builder.addInstance("square", builder.kRoot, 0, 0, glm::mat4(1));
  Renderer renderer(device(), builder.scene, nullptr);
  Settings settings = settingsOf(8, 8, {output::Aov::Color});
  settings.aa.temporal = true;
  const std::vector<scene::Camera> cameras(2, frontCamera());
  const std::vector<std::array<double, 2>> exposures{{0, 1}, {0, 1}, {-4, 1}, {-4, 3}, {2, -1}};
  for (size_t i = 0; i < exposures.size(); ++i) {
    const SceneState moment{.continues = i > 0, .exposures = {exposures[i].begin(), exposures[i].end()}};
    const std::vector<output::FrameOutput> frames = renderer.render(cameras, settings, moment);
    for (size_t view = 0; view < 2; ++view) {
      const double expected = 0.5 * std::exp2(exposures[i][view]);
      EXPECT_NEAR(imageOf(frames[view], output::Aov::Color).values[4 * (4 * 8 + 4)], expected, expected * 1e-3)
          << "frame " << i << ", view " << view;
    }
  }
}

TEST_F(TemporalTest, TheSameInputGivesTheSameBytes) {
  const scene::Scene scene = movingBox().load();
  EXPECT_EQ(render({scene, "", 0.2, 3}, true, 1), render({scene, "", 0.2, 3}, true, 1));
}

TEST_F(TemporalTest, EveryLayoutTakesIt) {
  const scene::Scene scene = movingBox().load();
  const Picture expected = render({scene, "", 0.2, 2}, true, 1, "plain").back();
  for (const char* layout : {"killzone2", "optimized", "blog"})
    EXPECT_LE(difference(render({scene, "", 0.2, 2}, true, 1, layout).back(), expected), 6) << layout;
}

}  // namespace
}  // namespace latelight::render::test
