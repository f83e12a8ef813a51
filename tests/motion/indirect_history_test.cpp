// The temporal filter of indirect light, compared with many samples and with closed forms: its error falls from frame
// to frame, uncovered surfaces show no ghosts, moving ones do not smear, and edits begin a new history.
#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "base/error.h"
#include "long_tests.h"
#include "motion/files.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class IndirectHistoryTest : public RenderTest {
 protected:
  static constexpr uint32_t kWidth = 64, kHeight = 48;

  // Moves along with the seconds of an animation, as `latelight render --frames` does.
  struct Sequence {
    const scene::Scene& scene;
    const scene::Environment& environment;
    double start = 0, step = 0;             // seconds
    double moves = 0;                       // meters per frame that the camera moves to the right
    std::optional<scene::Camera> camera{};  // in the first frame; none: the automatic one
  };

  static Settings settings(IndirectFilter filter, uint32_t samples = 4) {
    Settings s = settingsOf(kWidth, kHeight, {Aov::Color, Aov::Id, Aov::Normal});
    s.indirect = Indirect::OneBounce;
    s.indirectFilter = filter;
    s.samples = samples;
    return s;
  }

  static scene::Camera cameraAt(const Sequence& sequence, double frame) {
    scene::Camera camera = sequence.camera.value_or(cameraOf(sequence.scene, kWidth, kHeight));
    camera.toWorld[3] += camera.toWorld[0] * (frame * sequence.moves);
    return camera;
  }

  static SceneState stateAt(const Sequence& sequence, double frame, bool continues) {
    SceneState state{.previousCameras = {cameraAt(sequence, frame - 1)},
                     .nextCameras = {cameraAt(sequence, frame + 1)},
                     .continues = continues};
    if (sequence.step == 0) return state;
    const scene::Playback playback = scene::choosePlayback(sequence.scene, "", true);
    const auto pose = [&](double at) {
      return scene::poseAt(sequence.scene, playback, sequence.start + at * sequence.step);
    };
    state.poses = {pose(frame - 1), pose(frame), pose(frame + 1)};
    return state;
  }

  // Renders the frames of a sequence, and returns the last one.
  static output::FrameOutput last(const Sequence& sequence, const Settings& settings, uint32_t frames,
                                  uint32_t first = 0) {
    Renderer renderer(device(), sequence.scene, &sequence.environment);
    output::FrameOutput frame;
    for (uint32_t i = first; i < frames; ++i) {
      const scene::Camera camera = cameraAt(sequence, i);
      frame = std::move(renderer.render({&camera, 1}, settings, stateAt(sequence, i, i > first)).front());
    }
    return frame;
  }

  static output::FrameOutput alone(const Sequence& sequence, const Settings& settings, uint32_t frame) {
    return last(sequence, settings, frame + 1, frame);
  }

  // Root mean square difference of two pictures over the surfaces.
  static double difference(const output::FrameOutput& a, const output::FrameOutput& b) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
      if (imageOf(a, Aov::Id).ids[i] == 0) continue;
      for (size_t c = 0; c < 3; ++c, ++count)
        sum += std::pow(imageOf(a, Aov::Color).values[4 * i + c] - imageOf(b, Aov::Color).values[4 * i + c], 2);
    }
    return std::sqrt(sum / count);
  }

  // Compares the twelfth frame of a sequence with many samples, with its history and without.
  static void expectLessErrorWithHistory(const Sequence& moves, const char* what) {
    const output::FrameOutput truth = alone(moves, settings(IndirectFilter::None, 1024), 11);
    const double spatial = difference(alone(moves, settings(IndirectFilter::Spatial), 11), truth);
    const double temporal = difference(last(moves, settings(IndirectFilter::Temporal), 12), truth);
    fmt::print("{}: error {:.5f}, {:.5f} with history\n", what, spatial, temporal);
    EXPECT_LT(temporal, 0.75 * spatial);
  }
};

// A box in front of a wall, white and Lambertian.
scene::Scene boxAndWall(float away = 4, float half = 5) {
  scene::Scene scene = movingBox(away, half).load();
  for (scene::Material& material : scene.materials) {
    material.data.baseColor = glm::vec4(0.8f, 0.8f, 0.8f, 1);
    material.data.metallic = 0;
    material.data.roughness = 1;
    material.data.specular = 0;
  }
  return scene;
}

// With a static camera, the sample sequences go on from frame to frame.
TEST_F(IndirectHistoryTest, TheErrorFallsWithFrames) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  const Sequence still{scene, environment};
  const uint32_t samples = latelight::test::rounds(2048, 1024);
  const output::FrameOutput truth = last(still, settings(IndirectFilter::None, samples), 1);
  const double one = difference(last(still, settings(IndirectFilter::Temporal), 1), truth);
  const double four = difference(last(still, settings(IndirectFilter::Temporal), 4), truth);
  const double many = difference(last(still, settings(IndirectFilter::Temporal), 24), truth);
  fmt::print("still camera: error {:.5f} after one frame, {:.5f} after 4, {:.5f} after 24\n", one, four, many);
  EXPECT_LT(four, 0.75 * one);
  EXPECT_LT(many, 0.5 * one);
  // Metering renders pictures of its own, which are not part of the sequence.
  Settings automatic = settings(IndirectFilter::Temporal);
  automatic.exposure = {0, true};
  output::FrameOutput metered = last(still, automatic, 4);
  for (float& value : metered.aovs.front().values) value /= metered.exposure;
  EXPECT_NEAR(difference(metered, truth), four, 0.02 * four);
}

TEST_F(IndirectHistoryTest, AMovingCameraReducesTheError) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  expectLessErrorWithHistory({scene, environment, 0, 0, 0.05}, "moving camera");
}

TEST_F(IndirectHistoryTest, MovingObjectsDoNotSmear) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  expectLessErrorWithHistory({scene, environment, 0.2, 1 / 48.0}, "moving box");
}

// Radiance 1 + 0.9 cos of the angle to the viewer's direction: a white Lambertian surface, of which nothing is hidden,
// whose normal is at angle a reflects 1 + 0.6 cos a. The box in front of the wall hides less than 0.5 % of the wall's
// environment, and turns while it moves, so its faces are darker than the wall.
TEST_F(IndirectHistoryTest, UncoveredSurfacesShowNoGhosts) {
  scene::Scene scene = boxAndWall(40, 60);
  for (scene::Material& material : scene.materials) material.data.baseColor = glm::vec4(1);
  scene::FloatImage sky(64, 32);
  for (uint32_t y = 0; y < 32; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const double azimuth = ((x + 0.5) / 64 - 0.5) * 2 * std::numbers::pi;
      const double polar = (y + 0.5) / 32 * std::numbers::pi;
      // Toward +Z of the glTF frame, a quarter turn from the center column. The sign follows from the check below.
      const double toViewer = std::sin(polar) * std::sin(azimuth);
      for (size_t c = 0; c < 3; ++c) sky.pixels[4 * (size_t{y} * 64 + x) + c] = static_cast<float>(1 + 0.9 * toViewer);
      sky.pixels[4 * (size_t{y} * 64 + x) + 3] = 1;
    }
  const scene::Environment environment = scene::makeEnvironment(sky);
  const scene::Camera camera = scene::lookAt(scene, {0, 0, 8}, {0, 0, 0}, {}, 0.9f);
  const Sequence moves{scene, environment, 0.1, 1 / 12.0, 0, camera};
  constexpr uint32_t kFrames = 8;
  const output::FrameOutput frame = last(moves, settings(IndirectFilter::Temporal, 16), kFrames);
  const output::FrameOutput before = alone(moves, settings(IndirectFilter::Spatial, 1), kFrames - 3);
  const uint32_t wall = imageOf(frame, Aov::Id).ids[0];
  double worst = 0;
  size_t uncovered = 0, box = 0;
  for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
    const bool isWall = imageOf(frame, Aov::Id).ids[i] == wall;
    const float cosine = vec3At(imageOf(frame, Aov::Normal), i).z;
    const double expected = 1 + 0.6 * cosine;
    box += !isWall;
    if (!isWall || imageOf(before, Aov::Id).ids[i] == wall) continue;
    ++uncovered;
    worst = std::max(worst, std::abs(imageOf(frame, Aov::Color).values[4 * i] / expected - 1));
  }
  fmt::print("{} pixels uncovered within three frames, {} of the box; at most {:.4f} from the closed form\n", uncovered,
             box, worst);
  EXPECT_GT(uncovered, 20u);
  EXPECT_LT(worst, 0.04);
}

// The first frame of a history is that of the spatial filter, and an edit begins a new history.
TEST_F(IndirectHistoryTest, AnEditBeginsANewHistory) {
  scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  const Sequence still{scene, environment};
  const scene::Camera camera = cameraAt(still, 0);
  Renderer renderer(device(), scene, &environment);
  const auto render = [&](bool continues, uint32_t samples = 4) {
    const Settings s = settings(IndirectFilter::Temporal, samples);
    return imageOf(renderer.render({&camera, 1}, s, stateAt(still, 0, continues)).front(), Aov::Color).values;
  };
  const auto spatial = [&] { return imageOf(last(still, settings(IndirectFilter::Spatial), 1), Aov::Color).values; };
  const std::vector<float> first = render(false);
  EXPECT_EQ(first, spatial());
  EXPECT_NE(render(true), first);
  EXPECT_EQ(render(false), first) << "a cut begins a new history";
  EXPECT_NE(render(true), first);
  scene.instances[0].toWorld[3].x += 0.5;
  scene.edits.instances.note(0);
  const std::vector<float> moved = render(true);
  EXPECT_EQ(moved, spatial());
  EXPECT_NE(moved, first);
  render(true, 3);
  EXPECT_EQ(render(true), moved) << "other settings begin a new history";
}

TEST_F(IndirectHistoryTest, ViewsDoNotDependOnOthers) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  const Sequence moves{scene, environment, 0.2, 1 / 48.0};
  const std::vector<scene::Camera> cameras = {cameraAt(moves, 0), cameraAt({scene, environment, 0, 0, 0.4}, 1)};
  const Settings s = settings(IndirectFilter::Temporal);
  const auto render = [&](std::span<const scene::Camera> some) {
    Renderer renderer(device(), scene, &environment);
    std::vector<output::FrameOutput> frames;
    for (uint32_t i = 0; i < 4; ++i) {
      SceneState state = stateAt(moves, i, i > 0);
      state.previousCameras.clear(), state.nextCameras.clear();
      frames = renderer.render(some, s, state);
    }
    return frames;
  };
  const std::vector<output::FrameOutput> both = render(cameras);
  for (size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(imageOf(both[i], Aov::Color).values,
              imageOf(render(std::span(cameras).subspan(i, 1)).front(), Aov::Color).values);
}

// With TAA, the first picture averages jittered frames, of which the last one begins the history.
TEST_F(IndirectHistoryTest, ContinuesUnderTemporalAntiAliasing) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  const Sequence still{scene, environment};
  Settings s = settings(IndirectFilter::Temporal);
  s.aa.temporal = true;
  const output::FrameOutput frame = last(still, s, 6);
  s.indirectFilter = IndirectFilter::Spatial;
  const output::FrameOutput spatial = last(still, s, 6);
  EXPECT_NE(imageOf(frame, Aov::Color).values, imageOf(spatial, Aov::Color).values);
  EXPECT_LT(difference(frame, spatial), 0.05);
}

TEST_F(IndirectHistoryTest, RejectsPicturesOfSeveralFrames) {
  const scene::Scene scene = boxAndWall();
  const scene::Environment environment = constantEnvironment();
  const Sequence moves{scene, environment, 0.2, 1 / 48.0};
  Settings s = settings(IndirectFilter::Temporal);
  s.aa.superSampling = 2;
  EXPECT_THROW(last(moves, s, 1), Error);
  s.aa.superSampling = 1;
  s.aperture = readText<Aperture>("--aperture", "0.1");
  EXPECT_THROW(last(moves, s, 1), Error);
}

}  // namespace
}  // namespace latelight::render::test
