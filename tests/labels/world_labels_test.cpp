// Labels and keypoints of worlds: each view's equal those of the scene edited to the world's state.
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "labels/same_labels.h"
#include "models/models.h"
#include "placed.h"
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

// Squares of 8 x 8 pixels, with their edges on those of pixels, before two orthographic cameras. They cross the borders
// of some pictures. Beyond the border of another, they would occlude squares with which they share an image elsewhere.
struct SquareWorlds {
  static constexpr int64_t kWidth = 48, kHeight = 32, kSide = 8, kSquares = 4;
  static constexpr int64_t kShifts[] = {0, 24};  // columns from the first camera's picture to that of each camera
  static constexpr double kMetersPerPixel = 1.0 / 16;
  Scene scene;
  Worlds worlds{.count = 2};
  std::vector<PixelBox> squares;  // in the first camera's picture, world by world

  SquareWorlds() {
    constexpr float kHalf = kSide * kMetersPerPixel / 2;
    MeshData square{.name = "square", .indices = {0, 1, 2, 0, 2, 3}};
    square.positions = {{-kHalf, -kHalf, 0}, {kHalf, -kHalf, 0}, {kHalf, kHalf, 0}, {-kHalf, kHalf, 0}};
    const Handle<Mesh> mesh = scene.addMesh(square);
    const Handle<Material> material = scene.addMaterial(Material{.name = "plain", .doubleSided = true});
    for (int64_t i = 0; i < kSquares; ++i)
      worlds.instances.push_back(scene.addInstance(mesh, material, placed(0, 0, 0), "square" + std::to_string(i)));
    for (const int64_t shift : kShifts) {
      const double x = static_cast<double>(shift) * kMetersPerPixel;
      Camera& camera = worlds.cameras.emplace_back(scene.lookAt({x, 0, 5}, {x, 0, 0}));
      camera.orthographic = true;
      camera.halfHeight = kHeight * kMetersPerPixel / 2;
      camera.farClip = 50;
    }
  }

  void move(std::mt19937& random) {
    std::uniform_int_distribution<int64_t> column(-24, 64), row(-20, 44);
    squares.clear();
    worlds.transforms.clear();
    for (int64_t i = 0; i < worlds.count * kSquares; ++i) {
      const PixelBox& at = squares.emplace_back(PixelBox{column(random), row(random), kSide, kSide});
      const double x = static_cast<double>(at.x + (kSide - kWidth) / 2) * kMetersPerPixel;
      const double y = static_cast<double>((kHeight - kSide) / 2 - at.y) * kMetersPerPixel;
      worlds.transforms.push_back(placed(x, y, 0.1 * static_cast<double>(i % kSquares)));
    }
  }

  // Returns the part of a box within a rectangle.
  static PixelBox partOf(const PixelBox& box, const PixelBox& limits) {
    const int64_t x = std::max(box.x, limits.x), right = std::min(box.x + box.width, limits.x + limits.width);
    const int64_t y = std::max(box.y, limits.y), bottom = std::min(box.y + box.height, limits.y + limits.height);
    return x < right && y < bottom ? PixelBox{x, y, right - x, bottom - y} : PixelBox{};
  }

  // Returns the full boxes of a view's objects by node.
  std::map<std::string, PixelBox> boxesOf(size_t view) const {
    std::map<std::string, PixelBox> boxes;
    for (size_t i = 0; i < kSquares; ++i) {
      PixelBox box = squares[view / 2 * kSquares + i];
      box.x -= kShifts[view % 2];
      if (partOf(box, {0, 0, kWidth, kHeight}) == PixelBox{}) continue;
      boxes["/square" + std::to_string(i)] = partOf(box, {-kWidth, -kHeight, 3 * kWidth, 3 * kHeight});
    }
    return boxes;
  }
};

// Returns how many objects cross the border of their picture. Their full boxes and pixels must be the expected ones.
size_t expectFullBoxes(const Labels& labels, const std::map<std::string, PixelBox>& boxes) {
  EXPECT_EQ(labels.objects.size(), boxes.size());
  size_t across = 0;
  for (const ObjectLabel& object : labels.objects) {
    const PixelBox& box = boxes.at(object.node);
    EXPECT_TRUE(object.fullBox == box) << object.node;
    EXPECT_EQ(object.fullPixels, static_cast<uint64_t>(box.width * box.height)) << object.node;
    across += object.fullPixels > object.amodalPixels;
  }
  return across;
}

TEST_P(WorldLabels, CountPixelsBeyondTheBorderOfEachView) {
  SquareWorlds made;
  Renderer renderer(made.scene, testDevice());
  std::mt19937 random(11);
  size_t across = 0;
  for (int call = 0; call < 60; ++call) {
    made.move(random);
    const std::vector<Labels> labels = renderer.labels(made.worlds, small());
    ASSERT_EQ(labels.size(), 4u);
    for (size_t view = 0; view < labels.size(); ++view) {
      SCOPED_TRACE(testing::Message() << "view " << view << " of call " << call);
      across += expectFullBoxes(labels[view], made.boxesOf(view));
    }
  }
  EXPECT_GT(across, 60u);
  EXPECT_EQ(renderer.validationMessages(), std::vector<std::string>{});
}

INSTANTIATE_TEST_SUITE_P(Rasters, WorldLabels, testing::Values("hardware", "compute"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace latelight::test
