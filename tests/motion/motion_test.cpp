// Motion vectors of every pixel compared with reprojected positions, and poses computed by the device with those of the
// CPU.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "models/models.h"
#include "motion/files.h"
#include "motion/reference_motion.h"
#include "render/gbuffer/layout.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using output::Aov;

constexpr uint32_t kWidth = 160, kHeight = 120;
constexpr double kStep = 1.0 / 24;

SceneState momentOf(const scene::Scene& scene, double seconds, const std::string& animation = "") {
  const scene::Playback playback = scene::choosePlayback(scene, animation, false);
  return {.poses = {scene::poseAt(scene, playback, seconds - kStep), scene::poseAt(scene, playback, seconds),
                    scene::poseAt(scene, playback, seconds + kStep)}};
}

// Both cameras move: one sideways, and one by a rotation.
void moveCamera(SceneState& moment, const scene::Camera& camera) {
  scene::Camera before = camera, after = camera;
  before.toWorld = glm::translate(glm::dmat4(1), glm::dvec3(0.02f, -0.05f, 0.01f)) * camera.toWorld;
  after.toWorld = glm::rotate(camera.toWorld, 0.02, glm::dvec3(0.3, 0.2, 1));
  moment.previousCameras = {before};
  moment.nextCameras = {after};
}

class MotionTest : public RenderTest {
 protected:
  // The maximum difference over all pixels in which both see the same surface, which must be nearly all covered pixels.
  static void expectReprojected(const scene::Scene& scene, const scene::Camera& camera, const SceneState& moment,
                                double least, DataSurfaces surfaces = DataSurfaces::Opaque) {
    Renderer renderer(device(), scene, nullptr);
    Settings settings = settingsOf(kWidth, kHeight, {Aov::Motion, Aov::Depth});
    settings.dataSurfaces = surfaces;
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings, moment).front());
    const std::vector<ReferencePixel> expected = referenceMotion(scene, moment, camera, kWidth, kHeight);
    const std::vector<float>&motion = imageOf(frame, Aov::Motion).values, &depth = imageOf(frame, Aov::Depth).values;
    size_t drawn = 0, compared = 0;
    double worst = 0, longest = 0;
    for (size_t i = 0; i < expected.size(); ++i) {
      drawn += std::isfinite(depth[i]) || expected[i].depth > 0;
      if (!(std::abs(depth[i] - expected[i].depth) <= 1e-4 * expected[i].depth)) continue;
      ++compared;
      const dvec2 backward(motion[4 * i], motion[4 * i + 1]), forward(motion[4 * i + 2], motion[4 * i + 3]);
      worst =
          std::max({worst, glm::length(backward - expected[i].backward), glm::length(forward - expected[i].forward)});
      longest = std::max({longest, glm::length(expected[i].backward), glm::length(expected[i].forward)});
    }
    fmt::print("{}: {} of {} pixels, worst {:.5f} px of up to {:.2f}\n", scene.name, compared, drawn, worst, longest);
    EXPECT_GE(double(compared), 0.98 * double(drawn));
    EXPECT_GE(drawn, 500u);
    EXPECT_LE(worst, 0.01);
    EXPECT_GE(longest, least) << "nothing moved, so nothing was tested";
  }

  static void expectModelReprojected(const std::string& name, const std::string& animation, double seconds) {
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
    SceneState moment = momentOf(scene, seconds, animation);
    expectReprojected(scene, camera, moment, 0.5);
    moveCamera(moment, camera);
    expectReprojected(scene, camera, moment, 0.5);
  }
};

TEST_F(MotionTest, ModelsAgreeWithReprojection) {
  expectModelReprojected("skinned.glb", "bend", 0.4);
  expectModelReprojected("morphed.glb", "breathe", 0.3);
  for (const std::string& name : models::withReal({}, {"Fox.glb", "CesiumMan.glb"}))
    name == "Fox.glb" ? expectModelReprojected(name, "Run", 0.4) : expectModelReprojected(name, "", 0.7);
}

TEST_F(MotionTest, MovingCameraInTheHallAgreesWithReprojection) {
  const scene::Camera camera = cameraOf(hall(), kWidth, kHeight);
  SceneState moment;
  moveCamera(moment, camera);
  expectReprojected(hall(), camera, moment, 0.5);
}

// The rays hit glass, too, so it is visible everywhere.
TEST_F(MotionTest, BlendedSurfacesAgreeWithReprojectionWhereTheirDataLeave) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=1,glass=1");
  const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
  SceneState moment;
  moveCamera(moment, camera);
  expectReprojected(scene, camera, moment, 0.5, DataSurfaces::Any);
}

TEST_F(MotionTest, SyntheticFilesAgreeWithReprojection) {
  for (const auto& file : {movingBox(), morphingSquare(), bendingStrip()}) {
    const scene::Scene scene = file.load();
    const scene::Camera camera = frontPerspective(0.9f, 5);
    SceneState moment = momentOf(scene, 0.5);
    expectReprojected(scene, camera, moment, 0.5);
    moveCamera(moment, camera);
    expectReprojected(scene, camera, moment, 0.5);
  }
}

// The center of the box's front, computed by hand: at 0.5 s it has rotated by 45 degrees, and one frame before by 3.75
// degrees less.
TEST_F(MotionTest, BoxMovesAsItsAnimationSays) {
  const scene::Scene scene = movingBox().load();
  const SceneState moment = momentOf(scene, 0.5);
  const scene::Camera camera = frontPerspective(0.9f, 5);
  Renderer renderer(device(), scene, nullptr);
  const output::FrameOutput frame = std::move(
      renderer.render({&camera, 1}, settingsOf(kWidth, kHeight, {Aov::Motion, Aov::Position}), moment).front());
  const size_t pixel = kHeight / 2 * kWidth + kWidth / 2;
  const glm::dvec3 p(vec3At(imageOf(frame, Aov::Position), pixel));  // glTF's frame
  const auto boxAt = [](double t) {                                  // linear in time, as is slerp with a single angle
    glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(-1 + 2 * t, 0.5 * t, t));
    return glm::rotate(m, t * M_PI / 2, glm::dvec3(0, 1, 0));
  };
  const auto seen = [](glm::dvec3 q) {  // by a camera at z = 5 that looks along -Z
    const double scale = kHeight * 0.5 / std::tan(0.45) / (5 - q.z);
    return dvec2(kWidth * 0.5 + q.x * scale, kHeight * 0.5 - q.y * scale);
  };
  const glm::dvec4 local = glm::inverse(boxAt(0.5)) * glm::dvec4(p, 1);
  const dvec2 here(kWidth / 2 + 0.5, kHeight / 2 + 0.5);
  const dvec2 back = seen(boxAt(0.5 - kStep) * local) - here, ahead = seen(boxAt(0.5 + kStep) * local) - here;
  const float* motion = &imageOf(frame, Aov::Motion).values[4 * pixel];
  EXPECT_NEAR(motion[0], back.x, 0.01);
  EXPECT_NEAR(motion[1], back.y, 0.01);
  EXPECT_NEAR(motion[2], ahead.x, 0.01);
  EXPECT_NEAR(motion[3], ahead.y, 0.01);
  EXPECT_GT(glm::length(back), 0.5);
}

// At the limit of floats: a surface that comes from there, or goes there, has no position in the picture, but its
// motion is still a number.
TEST_F(MotionTest, ExtremeTransformsGiveNumbers) {
  const scene::Camera camera = frontPerspective(0.9f, 5);
  for (const char* path : {"translation", "scale"})
    for (const float end : {1e-38f, 1e10f, 1e20f, 1e30f, 1e36f, -1e36f, 3e38f}) {
      scene::test::GltfBuilder b = movingBox();
      const bool scales = std::string_view(path) == "scale";
      const int track = scales ? 0 : 1;  // the track of the box's own animation
      b.root["animations"][0]["channels"][track]["target"]["path"] = path;
      b.root["animations"][0]["samplers"][track]["output"] =
          b.positions({scales ? glm::vec3(1) : glm::vec3(0), glm::vec3(end, end, -end)});
      const scene::Scene scene = b.load();
      scene::Camera far = camera;
      far.toWorld[3] *= glm::vec4(1e30f, 1e30f, 1e30f, 1);
      Renderer renderer(device(), scene, nullptr);
      for (const double seconds : {0.0, 0.5, 1.0}) {
        SceneState moment = momentOf(scene, seconds);
        moment.previousCameras = {far};
        const output::FrameOutput frame =
            std::move(renderer.render({&camera, 1}, settingsOf(64, 48, {Aov::Motion, Aov::Depth}), moment).front());
        size_t wrong = 0;
        for (const float value : imageOf(frame, Aov::Motion).values) wrong += !std::isfinite(value);
        EXPECT_EQ(wrong, 0u) << path << " to " << end << " at " << seconds << " s";
      }
    }
}

TEST_F(MotionTest, NothingMovesAtRest) {
  const scene::Scene scene = movingBox().load();
  const scene::Camera camera = frontPerspective(0.9f, 5);
  const output::FrameOutput frame = renderOne(device(), scene, camera, settingsOf(kWidth, kHeight, {Aov::Motion}));
  // On GPUs, compilers may round only one of two equal positions, and subtract by a fused multiply-add: a unit in the
  // last place of NDC, in pixels.
  const float rounding = device().isCpu() ? 0 : 0.5f * kWidth * std::numeric_limits<float>::epsilon();
  for (float value : imageOf(frame, Aov::Motion).values) ASSERT_LE(std::abs(value), rounding);
}

// The background is infinitely far away: it stays in place if the camera only moves, and rotates with it.
TEST_F(MotionTest, BackgroundMovesWithTheCamerasTurn) {
  scene::Scene scene = movingBox().load();
  scene.instances.clear();
  const scene::Camera camera = frontPerspective(0.9f, 5);
  SceneState moment;
  moment.previousCameras = {camera};
  moment.previousCameras[0].toWorld = glm::rotate(camera.toWorld, 0.03, glm::dvec3(0, 0, 1));
  moment.nextCameras = {camera};
  moment.nextCameras[0].toWorld[3] += glm::dvec4(3, 2, 1, 0);
  Renderer renderer(device(), scene, nullptr);
  const output::FrameOutput frame =
      std::move(renderer.render({&camera, 1}, settingsOf(kWidth, kHeight, {Aov::Motion}), moment).front());
  const size_t pixel = 30 * kWidth + 40;
  const glm::dvec3 far =
      glm::dvec3(camera.toWorld * glm::vec4((40.5 - kWidth / 2.0) / (kHeight * 0.5 / std::tan(0.45)), 1,
                                            (kHeight / 2.0 - 30.5) / (kHeight * 0.5 / std::tan(0.45)), 0)) *
      1e9;
  const dvec2 expected = pixelOf(moment.previousCameras[0], kWidth, kHeight, far) - dvec2(40.5, 30.5);
  const float* motion = &imageOf(frame, Aov::Motion).values[4 * pixel];
  EXPECT_NEAR(motion[0], expected.x, 0.01);
  EXPECT_NEAR(motion[1], expected.y, 0.01);
  EXPECT_GT(glm::length(expected), 1);
  EXPECT_NEAR(motion[2], 0, 0.001);
  EXPECT_NEAR(motion[3], 0, 0.001);
}

// Killzone 2's layout stores motion in quarters of a pixel.
TEST_F(MotionTest, Killzone2KeepsMotionInItsEightBits) {
  const scene::Scene scene = movingBox().load();
  const scene::Camera camera = frontPerspective(0.9f, 5);
  SceneState moment = momentOf(scene, 0.5);
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Motion});
  Renderer renderer(device(), scene, nullptr);
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings, moment).front());
  settings.layout = &findLayout("killzone2");
  const output::RawGbuffer raw = renderer.readTargets(camera, settings, moment).gbuffer;
  const std::vector<float>& motion = imageOf(frame, Aov::Motion).values;
  const auto target = std::find_if(raw.targets.begin(), raw.targets.end(),
                                   [](const output::RawTarget& t) { return t.name == "motion"; });
  ASSERT_NE(target, raw.targets.end());
  size_t moved = 0;
  for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
    if (imageOf(frame, Aov::Motion).values[4 * i] == 0) continue;
    ++moved;
    for (size_t c = 0; c < 2; ++c) {
      const double pixels = (std::floor(target->values[4 * i + c] * 255 + 0.5) - 128) / 4;
      ASSERT_NEAR(pixels, motion[4 * i + c], 0.126) << i;
    }
  }
  EXPECT_GT(moved, 500u);
}

// A skinned mesh that leaves its rest position is not culled with it, and the device's vertices equal the CPU's.
TEST_F(MotionTest, DevicesVerticesLieWhereTheCpusDo) {
  for (const auto& file : {morphingSquare(), bendingStrip()}) {
    const scene::Scene scene = file.load();
    const scene::Camera camera = frontPerspective(0.9f, 5);
    const SceneState moment = momentOf(scene, 0.8);
    Renderer renderer(device(), scene, nullptr);
    const output::FrameOutput frame = std::move(
        renderer.render({&camera, 1}, settingsOf(kWidth, kHeight, {Aov::Depth, Aov::Normal}), moment).front());
    // The same geometry, posed on the CPU and static.
    scene::Scene posed = file.load();
    scene::Mesh& mesh = posed.meshes[0];
    const scene::Deformation& d = *scene.meshes[0].deformation;
    std::vector<glm::mat4> joints;
    if (d.skin >= 0) joints = scene::jointMatrices(scene.rig.skins[0], moment.poses.current);
    std::vector<float> weights;
    if (d.weightsNode >= 0) weights = moment.poses.current.weights[size_t(d.weightsNode)];
    scene::DeformedVertices vertices = scene::deform(d, joints, weights);
    mesh.positions = vertices.positions;
    mesh.attributes = vertices.attributes;
    mesh.deformation = nullptr;
    scene::findBounds(mesh);
    const output::FrameOutput expected =
        renderOne(device(), posed, camera, settingsOf(kWidth, kHeight, {Aov::Depth, Aov::Normal}));
    const std::vector<float>&a = imageOf(frame, Aov::Depth).values, &b = imageOf(expected, Aov::Depth).values;
    size_t drawn = 0, apart = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      if (!std::isfinite(b[i])) continue;
      ++drawn;
      const bool same =
          std::abs(a[i] - b[i]) <= 1e-5f * b[i] &&
          glm::length(vec3At(imageOf(frame, Aov::Normal), i) - vec3At(imageOf(expected, Aov::Normal), i)) <= 1e-4f;
      apart += !same;
    }
    EXPECT_GT(drawn, 500u);
    EXPECT_LE(apart, drawn / 200) << "pixels at edges apart, all are alike";
  }
}

}  // namespace
}  // namespace latelight::render::test
