// Two-pass occlusion culling of clusters: images and data equal those of a renderer without earlier frames, to the
// byte, and occluded clusters are not rasterized.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "long_tests.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/framing.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using output::Aov;

constexpr uint32_t kBalls = 1500, kClustersPerBall = 8;

// A wall of four squares in front of a cloud of balls; some balls are in front of the wall. All balls have the same
// kind of material; see addSquareOfFourKinds().
scene::Scene ballsBehindAWall(uint32_t kind = 0) {
  scene::SceneBuilder builder("balls");
  addSquareOfFourKinds(builder.scene);
  builder.scene.meshes.push_back(sphereMesh(0.12f));
  for (const float x : {-2.0f, 0.0f, 2.0f, 4.0f})
    builder.addInstance("wall", builder.kRoot, 0, 1,
                        glm::scale(glm::translate(glm::mat4(1), {x, 0, 0}), vec3(1, 1.5f, 1)));
  std::mt19937 random(5);
  std::uniform_real_distribution<float> across(-4, 4), up(-1.4f, 1.4f), away(-9, -0.3f);
  for (uint32_t i = 0; i < kBalls; ++i) {
    const float z = i % 30 == 0 ? 1.0f : away(random);
    builder.addInstance("ball", builder.kRoot, 1, kind, glm::translate(glm::mat4(1), {across(random), up(random), z}));
  }
  return std::move(builder.scene);
}

struct CameraPose {
  vec3 eye, target;
};
// Past the wall's edge, through the wall, into the cloud, and out again.
constexpr CameraPose kCameraPath[] = {
    {{0, 0, 4}, {0, 0, 0}},      {{0, 0, 4}, {0, 0, 0}},     {{0.05f, 0, 4}, {0, 0, 0}},  {{-5, 0.5f, 3}, {0, 0, -2}},
    {{-6, 0.5f, 1}, {0, 0, -2}}, {{0, 0, 0.4f}, {0, 0, -1}}, {{0, 0, -0.1f}, {0, 0, -3}}, {{0, 0, -5}, {0, 0.2f, 0}},
    {{0, 9, 0.1f}, {0, 0, -3}},  {{0, 0, 40}, {0, 0, 0}}};
std::vector<scene::Camera> cameraPath(const scene::Scene& scene) {
  const size_t step = latelight::test::runsInFull() ? 1 : 2;
  std::vector<scene::Camera> cameras;
  for (size_t i = 0; i < std::size(kCameraPath); i += step)
    cameras.push_back(scene::lookAt(scene, kCameraPath[i].eye, kCameraPath[i].target));
  return cameras;
}

class ClusterOcclusionTest : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (!device().isCpu()) GTEST_SKIP() << "skipped: on GPUs it pays with more clusters than these scenes have";
  }

  static void expectAlike(const output::FrameOutput& a, const output::FrameOutput& b) {
    ASSERT_EQ(a.aovs.size(), b.aovs.size());
    for (size_t i = 0; i < a.aovs.size(); ++i) EXPECT_EQ(a.aovs[i].values, b.aovs[i].values);
  }

  static void expectAlikeAlongThePath(const scene::Scene& scene, const Settings& settings) {
    Renderer renderer(device(), scene, nullptr);
    for (const scene::Camera& camera : cameraPath(scene))
      expectAlike(renderer.render({&camera, 1}, settings).front(), renderOne(device(), scene, camera, settings));
  }

  static Settings settings(std::vector<Aov> aovs = {Aov::Color, Aov::Depth, Aov::Id}) {
    Settings settings = settingsOf(160, 120, std::move(aovs));
    settings.raster = Raster::Compute;
    return settings;
  }
};

TEST_F(ClusterOcclusionTest, ImagesEqualThoseOfAFreshRenderer) {
  const scene::Scene scene = ballsBehindAWall();
  expectAlikeAlongThePath(scene, settings());
  Settings samples = settings({Aov::Color});
  samples.aa.samples = 4;
  expectAlikeAlongThePath(scene, samples);
  Settings superSampled = settings();
  superSampled.aa.superSampling = 2;
  expectAlikeAlongThePath(scene, superSampled);
}

TEST_F(ClusterOcclusionTest, MasksAndGlassToo) {
  expectAlikeAlongThePath(ballsBehindAWall(2), settings());
  scene::Scene glass = ballsBehindAWall();
  glass.materials[0].data.flags |= shared::kMaterialBlended;
  glass.materials[0].data.baseColor.a = 0.5f;
  Settings both = settings({Aov::Color, Aov::Depth});
  both.dataSurfaces = DataSurfaces::Any;
  expectAlikeAlongThePath(glass, both);
}

TEST_F(ClusterOcclusionTest, OrthographicViewsToo) {
  const scene::Scene scene = ballsBehindAWall();
  Renderer renderer(device(), scene, nullptr);
  for (scene::Camera camera : cameraPath(scene)) {
    camera.orthographic = true;
    camera.yHalf = 3;
    camera.farClip = 50;
    expectAlike(renderer.render({&camera, 1}, settings()).front(), renderOne(device(), scene, camera, settings()));
  }
}

TEST_F(ClusterOcclusionTest, ManyViewsEqualSingleViews) {
  const scene::Scene scene = ballsBehindAWall();
  Renderer renderer(device(), scene, nullptr);
  std::vector<scene::Camera> cameras = cameraPath(scene);
  for (int i = 0; i < 3; ++i) {
    std::ranges::reverse(cameras);  // each view index has a different camera than before
    const std::vector<output::FrameOutput> together = renderer.render(cameras, settings());
    for (size_t c = 0; c < cameras.size(); ++c)
      expectAlike(together[c], renderOne(device(), scene, cameras[c], settings()));
  }
}

// The cached occlusion is that of the scene before the edit.
TEST_F(ClusterOcclusionTest, EditsAreVisible) {
  scene::Scene scene = ballsBehindAWall();
  Renderer renderer(device(), scene, nullptr);
  const scene::Camera camera = cameraPath(scene).front();
  for (int i = 0; i < 8; ++i) {
    expectAlike(renderer.render({&camera, 1}, settings()).front(), renderOne(device(), scene, camera, settings()));
    if (i == 2) scene::setTransform(scene, 0, glm::translate(glm::mat4(1), vec3(0, 5, 0)));
    if (i == 4)
      for (uint32_t ball = 10; ball < 200; ++ball)
        scene::setTransform(scene, ball, glm::translate(glm::mat4(1), vec3(0.01f * static_cast<float>(ball), 0, 2)));
    if (i == 6) scene::removeInstance(scene, 1);
  }
}

TEST_F(ClusterOcclusionTest, OccludedClustersAreNotRasterized) {
  const scene::Scene scene = ballsBehindAWall();
  Renderer renderer(device(), scene, nullptr);
  const scene::Camera camera = cameraPath(scene).front();
  const auto counts = [&] {
    renderer.render({&camera, 1}, settings());
    const scene::Camera other =
        scene::lookAt(scene, {0, 0, 400}, {0, 0, 800});  // resolves the counts of the last frame
    renderer.render({&other, 1}, settingsOf(8, 8, {Aov::Color}));
    return renderer.clusterOcclusion().counts(OcclusionHistory::Steady);
  };
  const ClusterOcclusion::Counts first = counts();
  EXPECT_EQ(first.found, 0u) << "nothing was known, so that all were rasterized";
  EXPECT_GT(first.occluded, kBalls * kClustersPerBall * 8 / 10) << "most balls are behind the wall";
}

}  // namespace
}  // namespace latelight::render::test
