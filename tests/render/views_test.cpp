// Several cameras at once, the same camera twice, and positions that project back to their pixels.
#include <fmt/core.h>

#include <cmath>
#include <cstring>

#include "long_tests.h"
#include "models/models.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using output::Aov;

constexpr uint32_t kViewWidth = 100, kViewHeight = 60;

std::vector<Aov> everyAov() {
  std::vector<Aov> all;
  for (const output::AovInfo& info : output::aovs()) all.push_back(info.aov);
  return all;
}

// Perspective with a far plane, orthographic, and off-center; all cameras view the boxes.
std::vector<scene::Camera> threeCameras(const scene::Scene& scene) {
  std::vector<scene::Camera> cameras(3, scene.cameras.front());
  cameras[0].farClip = 40;
  cameras[1].orthographic = true;
  cameras[1].yHalf = 2.5f;
  cameras[1].farClip = 30;
  cameras[2].principal = {0.4f, -0.25f};
  cameras[2].toWorld[3] += glm::vec4(1, 0.5f, 0.5f, 0);
  return cameras;
}

bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

void expectSame(const output::FrameOutput& a, const output::FrameOutput& b) {
  EXPECT_FALSE(a.display.empty());
  EXPECT_TRUE(a.display == b.display) << "display";
  ASSERT_EQ(a.aovs.size(), b.aovs.size());
  for (size_t i = 0; i < a.aovs.size(); ++i) {
    EXPECT_TRUE(sameBits(a.aovs[i].values, b.aovs[i].values)) << output::info(a.aovs[i].aov).name;
    EXPECT_TRUE(a.aovs[i].ids == b.aovs[i].ids);
    EXPECT_FALSE(a.aovs[i].values.empty() && a.aovs[i].ids.empty());
  }
}

class ViewsTest : public RenderTest {
 protected:
  // Compares cameras at once with single cameras, and a first call with a second one.
  static void compare(const scene::Scene& scene, std::span<const scene::Camera> cameras, Settings settings) {
    const scene::Environment studio = scene::loadEnvironment("studio");
    settings.display = true;
    if (settings.aovs.empty()) settings.aovs = everyAov();
    Renderer renderer(device(), scene, &studio);
    const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
    const std::vector<output::FrameOutput> again = renderer.render(cameras, settings);
    Renderer other(device(), scene, &studio);
    for (size_t i = 0; i < cameras.size(); ++i) {
      SCOPED_TRACE(fmt::format("camera {}", i));
      {
        SCOPED_TRACE("the same call twice");
        expectSame(together[i], again[i]);
      }
      SCOPED_TRACE("alone, by another renderer");
      expectSame(together[i], other.render(cameras.subspan(i, 1), settings).front());
    }
    EXPECT_FALSE(together[0].display == together[1].display);  // the cameras must differ
  }
};

// More cameras than an image has array layers.
TEST_F(ViewsTest, ManyCamerasAreRenderedInTurn) {
  const scene::Scene scene = scene::load("builtin:boxes");
  std::vector<scene::Camera> cameras(300, scene.cameras.front());
  for (size_t i = 0; i < cameras.size(); ++i) cameras[i].toWorld[3].x += 0.01f * static_cast<float>(i);
  const Settings settings{.width = 24, .height = 16, .aovs = {Aov::Depth}};
  Renderer renderer(device(), scene, nullptr);
  const std::vector<output::FrameOutput> all = renderer.render(cameras, settings);
  ASSERT_EQ(all.size(), cameras.size());
  for (size_t i : {size_t{0}, size_t{255}, size_t{256}, size_t{299}}) {
    SCOPED_TRACE(fmt::format("camera {}", i));
    expectSame(all[i], renderer.render({&cameras[i], 1}, settings).front());
  }
  EXPECT_FALSE(all[0].display == all[299].display);
}

TEST_F(ViewsTest, ThreeAtOnceEqualSingleViews) {
  const scene::Scene scene = scene::load("builtin:boxes");
  compare(scene, threeCameras(scene), settingsOf(kViewWidth, kViewHeight));
}

TEST_F(ViewsTest, ThreeAtOnceEqualSingleViewsSupersampledInAnotherLayout) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Settings settings = settingsOf(kViewWidth, kViewHeight);
  settings.aa.superSampling = 2;
  settings.layout = &findLayout("optimized");
  settings.background.kind = Background::Environment;
  compare(scene, threeCameras(scene), settings);
}

// Shadow maps are chosen, fitted and drawn per view: the cameras see different lights, and one of them sees none.
scene::Scene litHall() {
  return scene::load("builtin:hall,triangles=50k,lights=12,glass=1");
}

std::vector<scene::Camera> hallCameras(const scene::Scene& scene) {
  std::vector<scene::Camera> cameras(4, cameraOf(scene, kViewWidth, kViewHeight));
  cameras[1].toWorld[3] += glm::vec4(1, 6, 0.5f, 0);
  cameras[2].orthographic = true;
  cameras[2].yHalf = 6;
  cameras[3].toWorld[3].z += 1000;
  return cameras;
}

TEST_F(ViewsTest, ManyAtOnceWithShadowsEqualSingleViews) {
  const scene::Scene scene = litHall();
  Settings settings = settingsOf(60, 40, {Aov::Color, Aov::Depth, Aov::LightsUsed});
  settings.sun = SunLight{.azimuth = 0.5f, .elevation = 0.8f};
  settings.dataSurfaces = DataSurfaces::Any;
  for (const auto& [format, filter, layout, lighting] : {std::tuple{"d32", "pcf", "compact", "clustered"},
                                                         {"rgba8-classic", "pcss", "killzone2", "fullscreen"},
                                                         {"d16", "hard", "exact", "volumes"},
                                                         {"rgba8", "pcf", "compact", "forward"},
                                                         {"d32", "pcf", "compact", "forward-multipass"}}) {
    // Techniques that draw are the same with either raster, so one run is sufficient.
    if (testRaster() == Raster::Compute && findTechnique(lighting).draws) continue;
    SCOPED_TRACE(fmt::format("{}, {}, {}, {}", format, filter, layout, lighting));
    settings.shadows = readChoice<ShadowFormat>("--shadows", format);
    settings.shadowFilter = readChoice<ShadowFilter>("--shadow-filter", filter);
    settings.layout = &findLayout(layout);
    settings.lighting = &findTechnique(lighting);
    compare(scene, hallCameras(scene), settings);
  }
}

// Each camera has its own history.
TEST_F(ViewsTest, TemporalSequencesOfManyCamerasEqualSingleSequences) {
  const scene::Scene scene = litHall();
  Settings settings = settingsOf(60, 40, {Aov::Depth, Aov::Motion});
  settings.display = true;
  settings.shadows = ShadowFormat::D32;
  settings.aa.temporal = true;
  const auto at = [&](int frame) {
    std::vector<scene::Camera> cameras = hallCameras(scene);
    for (scene::Camera& camera : cameras) camera.toWorld[3].x += 0.02f * static_cast<float>(frame);
    return cameras;
  };
  Renderer together(device(), scene, nullptr);
  std::vector<std::unique_ptr<Renderer>> alone;
  for (size_t i = 0; i < at(0).size(); ++i) alone.push_back(std::make_unique<Renderer>(device(), scene, nullptr));
  const int frames = latelight::test::rounds(3, 2);
  for (int frame = 0; frame < frames; ++frame) {
    SCOPED_TRACE(fmt::format("frame {}", frame));
    const SceneState all{
        .poses = {}, .previousCameras = at(frame - 1), .nextCameras = at(frame + 1), .continues = frame > 0};
    const std::vector<output::FrameOutput> frames = together.render(at(frame), settings, all);
    for (size_t i = 0; i < alone.size(); ++i) {
      SCOPED_TRACE(fmt::format("camera {}", i));
      const SceneState one{.poses = {},
                           .previousCameras = {all.previousCameras[i]},
                           .nextCameras = {all.nextCameras[i]},
                           .continues = frame > 0};
      const scene::Camera camera = at(frame)[i];
      expectSame(frames[i], alone[i]->render({&camera, 1}, settings, one).front());
    }
  }
}

TEST_F(ViewsTest, TexturedModelsAreTheSameEachTime) {
  for (const std::string& name : models::withReal({"textured.glb"}, {"DamagedHelmet.glb"})) {
    SCOPED_TRACE(name);
    const scene::Scene scene = scene::load(models::modelPath(name));
    std::vector<scene::Camera> cameras(2, cameraOf(scene, kViewWidth, kViewHeight));
    cameras[1].verticalFov *= 0.5f;
    compare(scene, cameras, settingsOf(kViewWidth, kViewHeight));
  }
}

// The intrinsic matrix K and the pose, as the side file states them (docs/conventions.md).
struct Pinhole {
  dvec2 focal, center;
  dmat4 toCamera;  // in OpenCV's frame
  bool orthographic;

  Pinhole(const scene::Camera& camera, const scene::Scene& scene, bool zUp)
      : focal(0.5 * kViewHeight / (camera.orthographic ? camera.yHalf : std::tan(0.5 * camera.verticalFov))),
        center(0.5 * kViewWidth * (1 + camera.principal.x), 0.5 * kViewHeight * (1 - camera.principal.y)),
        toCamera(glm::inverse(openCvPose(camera, scene, zUp))),
        orthographic(camera.orthographic) {}

  dvec2 project(dvec3 inCamera) const { return dvec2(inCamera) * focal / (orthographic ? 1 : inCamera.z) + center; }
};

TEST_F(ViewsTest, PositionsProjectBackToTheirPixels) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Settings settings = settingsOf(kViewWidth, kViewHeight, {Aov::Position, Aov::Depth, Aov::Distance});
  for (const scene::Camera& camera : threeCameras(scene))
    for (bool zUp : {false, true}) {
      SCOPED_TRACE(
          fmt::format("orthographic {}, principal point {}, z-up {}", camera.orthographic, camera.principal.x, zUp));
      settings.axes = zUp ? Axes::ZUp : Axes::File;
      const output::FrameOutput frame = renderOne(device(), scene, camera, settings);
      const Pinhole pinhole(camera, scene, zUp);
      size_t covered = 0;
      double worst = 0, worstDepth = 0, worstDistance = 0;
      for (size_t i = 0; i < size_t{kViewWidth} * kViewHeight; ++i) {
        const double depth = imageOf(frame, Aov::Depth).values[i], distance = imageOf(frame, Aov::Distance).values[i];
        if (std::isinf(depth)) continue;
        ++covered;
        const dvec3 p = pinhole.toCamera * dvec4(vec3At(imageOf(frame, Aov::Position), i), 1);
        const dvec2 center(static_cast<double>(i % kViewWidth) + 0.5, static_cast<double>(i / kViewWidth) + 0.5);
        worst = std::max(worst, glm::length(pinhole.project(p) - center));
        worstDepth = std::max(worstDepth, std::abs(p.z - depth) / depth);
        worstDistance =
            std::max(worstDistance, std::abs((camera.orthographic ? p.z : glm::length(p)) - distance) / distance);
      }
      EXPECT_GT(covered, kViewWidth * kViewHeight / 2u);
      EXPECT_LT(worst, 1e-3);  // in pixels
      EXPECT_LT(worstDepth, 1e-5);
      EXPECT_LT(worstDistance, 1e-5);
    }
}

TEST_F(ViewsTest, NormalsAreInTheRequestedFrame) {
  const scene::Scene scene = scene::load("builtin:boxes");
  scene::Camera camera = threeCameras(scene)[2];
  const float turn = 0.3f;  // about the vertical axis, so that the frames differ by more than a permutation of axes
  camera.toWorld[0] = glm::vec4(std::cos(turn), std::sin(turn), 0, 0);
  camera.toWorld[1] = glm::vec4(-std::sin(turn), std::cos(turn), 0, 0);
  Settings settings = settingsOf(kViewWidth, kViewHeight, {Aov::Normal, Aov::GeoNormal});
  const output::FrameOutput world = renderOne(device(), scene, camera, settings);
  const glm::dmat3 toCamera(glm::inverse(openCvPose(camera, scene, false)));
  for (auto [frame, sign] : {std::pair{NormalFrame::OpenCv, 1.0}, {NormalFrame::OpenGl, -1.0}}) {
    settings.normalFrame = frame;
    const output::FrameOutput local = renderOne(device(), scene, camera, settings);
    for (Aov aov : {Aov::Normal, Aov::GeoNormal})
      for (size_t i = 0; i < size_t{kViewWidth} * kViewHeight; ++i) {
        const dvec3 expected = dvec3(1, sign, sign) * (toCamera * dvec3(vec3At(imageOf(world, aov), i)));
        ASSERT_LT(glm::length(dvec3(vec3At(imageOf(local, aov), i)) - expected), 1e-6) << "pixel " << i;
      }
  }
}

}  // namespace
}  // namespace latelight::render::test
