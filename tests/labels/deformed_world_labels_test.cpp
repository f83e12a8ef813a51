// Labels of worlds with joints and vertices of their own: each view's equal those of the animated or edited scene.
#include <latelight/latelight.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "labels/same_labels.h"
#include "models/models.h"
#include "render/submit/session.h"
#include "scene/load/load.h"
#include "test_device.h"
#include "worlds/joint_arrays.h"

namespace latelight::test {
namespace {

constexpr uint32_t kPoses = 4;

class DeformedWorldLabels : public testing::TestWithParam<const char*> {
 protected:
  Options small() const {
    Options options;
    options.width = 48;
    options.height = 36;
    options.raster = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(Rasters, DeformedWorldLabels, testing::Values("hardware", "compute"),
                         [](const auto& info) { return std::string(info.param); });

std::vector<Camera> camerasOf(const Scene& scene) {
  std::vector<Camera> cameras = {scene.defaultCamera(4.0f / 3), scene.defaultCamera(4.0f / 3)};
  cameras[1].cameraToWorld[3] += 0.7;  // the figure crosses the picture's edge
  cameras[1].cameraToWorld[7] += 0.4;
  return cameras;
}

std::vector<Keypoint> jointKeypoints(const std::vector<std::string>& joints) {
  std::vector<Keypoint> keypoints;
  for (const std::string& joint : joints) {
    keypoints.push_back({"inside", joint, {0, 0, 0}, 0.5});
    keypoints.push_back({"occluded", joint, {0, 0.1, -0.2}});
    keypoints.push_back({"outside", joint, {0, 0.2, 2}});
  }
  return keypoints;
}

// Poses of an animation, given as transforms of joints, have the labels of the animation.
TEST_P(DeformedWorldLabels, OfJointsEqualThoseOfTheAnimation) {
  const std::string file = models::modelPath("skinned.glb").string();
  const scene::Scene internal = scene::load(file);
  Scene scene(file), animated(file);
  Worlds worlds{.count = kPoses, .joints = scene.joints(scene.instances()[0]), .cameras = camerasOf(scene)};
  JointArrays arrays;
  std::array<Options, kPoses> posed;
  for (uint32_t world = 0; world < kPoses; ++world) {
    render::Settings settings;
    settings.time = 0.13 + 0.2 * world;
    settings.animation = "bend";
    arrays.add(internal, worlds.joints, render::posesAt(internal, settings));
    posed[world] = small();
    posed[world].time = settings.time;
    posed[world].animation = settings.animation;
  }
  worlds.arrays.jointTransforms = {.element = WorldArray::Element::Float64, .host = arrays.numbers[0].data()};
  Renderer renderer(scene, testDevice()), alone(animated, testDevice());
  const std::vector<Labels> labels = renderer.labels(worlds, small());
  const std::vector<Keypoint> keypoints = jointKeypoints(worlds.joints);
  const auto points = renderer.keypoints(worlds, keypoints, small());
  ASSERT_EQ(labels.size(), 2 * kPoses);
  size_t across = 0;
  std::array<size_t, 3> seen{};
  for (size_t view = 0; view < labels.size(); ++view) {
    const Camera& camera = worlds.cameras[view % 2];
    expectSame(labels[view], alone.labels(camera, posed[view / 2]), view);
    for (const ObjectLabel& object : labels[view].objects) across += object.fullPixels > object.amodalPixels;
    const std::vector<KeypointLabel> expected = alone.keypoints(camera, keypoints, posed[view / 2]);
    for (size_t i = 0; i < keypoints.size(); ++i) {
      const std::string what = keypoints[i].name + " of " + keypoints[i].node + " in view " + std::to_string(view);
      EXPECT_EQ(points[view][i].position, expected[i].position) << what;
      expectNear(points[view][i].pixel, expected[i].pixel, what);
      EXPECT_EQ(points[view][i].visibility, expected[i].visibility) << what;
      ++seen[expected[i].visibility];
    }
  }
  EXPECT_GT(across, 0u);
  for (const size_t count : seen) EXPECT_GT(count, 3u);
  EXPECT_NE(labels[0].objects[0].boxMax, labels[2].objects[0].boxMax);
  EXPECT_EQ(renderer.validationMessages(), std::vector<std::string>{});
}

// Joints that all move by the same distance move boxes and keypoints by that distance.
TEST_P(DeformedWorldLabels, MoveWithTheJoints) {
  const std::string file = models::modelPath("static_skin.glb").string();
  const scene::Scene internal = scene::load(file);
  Scene scene(file);
  Worlds worlds{.count = 2, .joints = scene.joints(scene.instances()[0]), .cameras = {scene.defaultCamera(4.0f / 3)}};
  const scene::Pose rest = scene::restPose(internal);
  JointArrays arrays;
  for (const double right : {0.0, 0.25}) {
    render::Poses poses{rest, rest, rest};
    for (glm::dmat4& world : poses.current.world) world[3].x += right;
    arrays.add(internal, worlds.joints, poses);
  }
  worlds.arrays.jointTransforms = {.element = WorldArray::Element::Float64, .host = arrays.numbers[0].data()};
  Renderer renderer(scene, testDevice());
  const std::vector<Labels> labels = renderer.labels(worlds, small());
  const std::vector<Keypoint> keypoints = {{"joint", worlds.joints.back(), {0, 0.1, 0}}};
  const auto points = renderer.keypoints(worlds, keypoints, small());
  EXPECT_NEAR(points[1][0].position[0] - points[0][0].position[0], 0.25, 1e-12);
  ASSERT_EQ(labels[0].objects.size(), labels[1].objects.size());
  ASSERT_FALSE(labels[0].objects.empty());
  for (size_t i = 0; i < labels[0].objects.size(); ++i) {
    EXPECT_NEAR(labels[1].objects[i].boxMin[0] - labels[0].objects[i].boxMin[0], 0.25, 1e-6);
    EXPECT_NEAR(labels[1].objects[i].boxMax[0] - labels[0].objects[i].boxMax[0], 0.25, 1e-6);
    EXPECT_GT(labels[1].objects[i].amodalBox.x, labels[0].objects[i].amodalBox.x);
  }
}

// Moved vertices have the labels of the scene whose meshes are replaced.
TEST_P(DeformedWorldLabels, OfVerticesEqualThoseOfTheEditedScene) {
  const std::string file = models::modelPath("textured.glb").string();
  Scene scene(file), edited(file);
  Worlds worlds{.count = kPoses, .cameras = camerasOf(scene)};
  worlds.meshes = scene.meshes();
  worlds.meshes.resize(std::min<size_t>(worlds.meshes.size(), 2));
  std::vector<float> numbers;
  std::vector<std::vector<MeshData>> moved(kPoses);
  for (uint32_t world = 0; world < kPoses; ++world)
    for (const Handle<Mesh> mesh : worlds.meshes) {
      MeshData& data = moved[world].emplace_back(scene.meshData(mesh));
      for (std::array<float, 3>& p : data.positions) {
        p[1] += 0.1f * std::sin(3 * p[0] + static_cast<float>(world));
        numbers.insert(numbers.end(), p.begin(), p.end());
      }
    }
  worlds.arrays.vertices = {.element = WorldArray::Element::Float32, .rows = 3, .host = numbers.data()};
  Renderer renderer(scene, testDevice()), alone(edited, testDevice());
  const std::vector<Labels> labels = renderer.labels(worlds, small());
  ASSERT_EQ(labels.size(), 2 * kPoses);
  for (size_t view = 0; view < labels.size(); ++view) {
    for (size_t i = 0; view % 2 == 0 && i < worlds.meshes.size(); ++i)
      edited.setMesh(edited.meshes()[i], moved[view / 2][i]);
    expectSame(labels[view], alone.labels(worlds.cameras[view % 2], small()), view);
  }
  EXPECT_NE(labels[0].objects[0].boxMax, labels[2].objects[0].boxMax);
}

}  // namespace
}  // namespace latelight::test
