// Labels and keypoints of worlds: each view's equal those of the scene edited to the world's state.
#include <latelight/latelight.h>

#include <cmath>
#include <random>

#include "labels/same_labels.h"
#include "models/models.h"
#include "render/support.h"
#include "test_device.h"

namespace latelight::test {
namespace {

constexpr uint32_t kWorlds = 6, kInstances = 5;

Transform randomTransform(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-1.5, 1.5), angle(-3, 3), size(0.3, 1.2);
  const double c = std::cos(angle(random)), s = std::sin(angle(random)), x = size(random), y = size(random);
  const double length = std::hypot(c, s), cosine = c / length, sine = s / length;
  return {cosine * x, 0, sine * y,   place(random), 0, x, 0, place(random),
          -sine * x,  0, cosine * y, place(random), 0, 0, 0, 1};
}

// Boxes and squares in random places. One box crosses the picture's edge in some worlds, and some instances do not
// exist in some worlds.
struct RandomWorlds {
  Scene scene;
  std::vector<Handle<Instance>> instances;
  Worlds worlds;

  RandomWorlds() {
    MeshData box{.name = "box"};
    for (int i = 0; i < 8; ++i)
      box.positions.push_back({i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f});
    box.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const Handle<Mesh> mesh = scene.addMesh(box);
    const Handle<Material> material = scene.addMaterial(Material{.name = "plain", .doubleSided = true});
    std::mt19937 random(7);
    for (uint32_t i = 0; i < kInstances; ++i)
      instances.push_back(scene.addInstance(mesh, material, randomTransform(random), "box" + std::to_string(i)));
    worlds.count = kWorlds;
    worlds.instances = {instances[3], instances[0], instances[4], instances[1]};  // the others stay
    for (size_t i = 0; i < kWorlds * worlds.instances.size(); ++i) {
      worlds.transforms.push_back(randomTransform(random));
      worlds.exists.push_back(random() % 4 != 0);
    }
    worlds.cameras = {scene.lookAt({0, 0, 5}, {0, 0, 0}, 40), scene.lookAt({3, 2, 4}, {0.5, 0, 0}, 35)};
    worlds.cameras[1].orthographic = true;
    worlds.cameras[1].halfHeight = 1.5;
    worlds.cameras[1].farClip = 50;
  }

  // Calls `compare` with each view's index and camera, after the scene is edited to its world. Instances that do not
  // exist are removed, with their nodes, or moved out of sight.
  template <typename Compare>
  void forEachView(bool removes, Compare compare) {
    for (uint32_t world = 0; world < kWorlds; ++world) {
      RandomWorlds edited;
      const size_t listed = worlds.instances.size();
      const uint32_t order[] = {3, 0, 4, 1};
      for (size_t i = 0; i < listed; ++i) {
        const Handle<Instance> instance = edited.instances[order[i]];
        edited.scene.setTransform(instance, worlds.transforms[world * listed + i]);
        if (worlds.exists[world * listed + i] != 0) continue;
        if (removes)
          edited.scene.removeInstance(instance);
        else
          edited.scene.setTransform(instance, {1, 0, 0, 900, 0, 1, 0, 900, 0, 0, 1, 900, 0, 0, 0, 1});
      }
      for (size_t camera = 0; camera < worlds.cameras.size(); ++camera)
        compare(world * worlds.cameras.size() + camera, edited.scene, worlds.cameras[camera]);
    }
  }
};

class WorldLabels : public testing::TestWithParam<const char*> {
 protected:
  Options small() const {
    Options options;
    options.width = 48;
    options.height = 32;
    options.raster = GetParam();
    return options;
  }
};

TEST_P(WorldLabels, EqualThoseOfEditedScenes) {
  RandomWorlds random;
  Renderer renderer(random.scene, testDevice());
  const std::vector<Labels> labels = renderer.labels(random.worlds, small());
  ASSERT_EQ(labels.size(), kWorlds * 2);
  size_t occluded = 0, across = 0;
  random.forEachView(true, [&](size_t view, const Scene& scene, const Camera& camera) {
    Renderer alone(scene, testDevice());
    expectSame(labels[view], alone.labels(camera, small()), view);
    for (const ObjectLabel& object : labels[view].objects) {
      occluded += object.visibleShare < 1;
      across += object.fullPixels > object.amodalPixels;
    }
  });
  EXPECT_GT(occluded, 10u);
  EXPECT_GT(across, 3u);
  EXPECT_EQ(renderer.validationMessages(), std::vector<std::string>{});
}

TEST_P(WorldLabels, KeypointsEqualThoseOfEditedScenes) {
  RandomWorlds random;
  Renderer renderer(random.scene, testDevice());
  std::vector<Keypoint> keypoints;
  for (uint32_t i = 0; i < kInstances; ++i) {
    const std::string node = "/box" + std::to_string(i);
    keypoints.push_back({"corner", node, {0.49, 0.49, 0.49}});
    keypoints.push_back({"face", node, {0.1, 0.2, 0.5}});
    keypoints.push_back({"above", node, {0, 0.9, 0}});
    keypoints.push_back({"inside", node, {0, 0, 0}, 0.4});
  }
  const auto labels = renderer.keypoints(random.worlds, keypoints, small());
  ASSERT_EQ(labels.size(), kWorlds * 2);
  std::array<size_t, 3> seen{};
  random.forEachView(false, [&](size_t view, const Scene& scene, const Camera& camera) {
    Renderer alone(scene, testDevice());
    const std::vector<KeypointLabel> expected = alone.keypoints(camera, keypoints, small());
    for (size_t i = 0; i < keypoints.size(); ++i) {
      const size_t listed = random.worlds.instances.size(), world = view / 2, box = i / 4;
      const size_t positionInList[] = {1, 3, 4, 0, 2};
      const size_t position = positionInList[box];
      if (position < listed && random.worlds.exists[world * listed + position] == 0) continue;
      const std::string what = keypoints[i].name + " of " + keypoints[i].node + " in view " + std::to_string(view);
      expectNear(labels[view][i].position, expected[i].position, what);
      expectNear(labels[view][i].pixel, expected[i].pixel, what);
      EXPECT_NEAR(labels[view][i].depth, expected[i].depth, 1e-9) << what;
      EXPECT_EQ(labels[view][i].visibility, expected[i].visibility) << what;
      ++seen[expected[i].visibility];
    }
  });
  for (const size_t count : seen) EXPECT_GT(count, 5u);
}

TEST_P(WorldLabels, RejectAnExposureTime) {
  RandomWorlds random;
  Renderer renderer(random.scene, testDevice());
  Options options = small();
  options.shutter = 0.1;
  EXPECT_THROW(renderer.labels(random.worlds, options), Error);
}

INSTANTIATE_TEST_SUITE_P(Rasters, WorldLabels, testing::Values("hardware", "compute"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace latelight::test
