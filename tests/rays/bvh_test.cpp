// BVHs that the host builds.
#include "render/rays/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/parallel.h"
#include "rays/bvh_checks.h"

namespace latelight::render::test {
namespace {

using shared::RayNode;

void expectSoundBvh(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth) {
  expectSound(buildBvh(boxes, maxLeaf, maxDepth), boxes, maxLeaf, maxDepth);
}

std::vector<Box> randomBoxes(size_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-10, 10), size(0, 0.5f);
  std::vector<Box> boxes(count);
  for (Box& box : boxes) {
    box.low = {place(random), place(random), place(random)};
    box.high = box.low + glm::vec3(size(random), size(random), size(random));
  }
  return boxes;
}

TEST(Bvh, IsEmptyWithoutItems) {
  EXPECT_TRUE(buildBvh({}, 4, 44).nodes.empty());
}

TEST(Bvh, HoldsEveryItemOnceInItsBox) {
  for (const size_t count : {1, 2, 3, 4, 5, 100, 40000})
    for (const uint32_t maxLeaf : {1u, 4u}) expectSoundBvh(randomBoxes(count), maxLeaf, 27);
}

TEST(Bvh, StaysShallowForAnyBoxes) {
  std::vector<Box> equal(1000, Box{glm::vec3(1), glm::vec3(2)});
  expectSoundBvh(equal, 4, 10);
  std::vector<Box> nested;  // each split by area would separate only the largest boxes
  for (int i = 0; i < 200; ++i) nested.push_back({glm::vec3(0), glm::vec3(std::exp2(static_cast<float>(i % 120)))});
  expectSoundBvh(nested, 1, 8);
}

TEST(Bvh, IsTheSameWithAnyNumberOfThreads) {
  const std::vector<Box> boxes = randomBoxes(100000);
  const Bvh parallel = buildBvh(boxes, 4, 44);
  const SerialScope serial;
  const Bvh alone = buildBvh(boxes, 4, 44);
  EXPECT_EQ(alone.items, parallel.items);
  ASSERT_EQ(alone.nodes.size(), parallel.nodes.size());
  EXPECT_TRUE(std::ranges::equal(alone.nodes, parallel.nodes, [](const RayNode& x, const RayNode& y) {
    return x.lowA == y.lowA && x.highA == y.highA && x.lowB == y.lowB && x.highB == y.highB && x.a == y.a && x.b == y.b;
  }));
}

// Two unit cubes at a distance, in two leaves of one node. Half of the surface of a cube is 3, that of the node's
// box 7.
TEST(Bvh, CostFollowsFromAreas) {
  const std::vector<Box> boxes{{glm::vec3(0), glm::vec3(1)}, {glm::vec3(2, 0, 0), glm::vec3(3, 1, 1)}};
  EXPECT_NEAR(sahCost(buildBvh(boxes, 1, 44)), (7.0 + 3.0 + 3.0) / 7.0, 1e-6);
}

}  // namespace
}  // namespace latelight::render::test
