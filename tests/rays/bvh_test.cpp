// The host's BVH: every item is in one leaf, every box contains its subtree, and no path is too deep.
#include "render/rays/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/parallel.h"

namespace latelight::render::test {
namespace {

using shared::RayNode;

bool contains(const Box& outer, const Box& inner) {
  return glm::all(glm::lessThanEqual(outer.low, inner.low)) && glm::all(glm::greaterThanEqual(outer.high, inner.high));
}

struct Walk {
  const Bvh& bvh;
  std::span<const Box> boxes;
  uint32_t maxLeaf;
  std::vector<int> seen;
  uint32_t depth = 0;
  bool sound = true;

  void child(uint32_t reference, const Box& box, uint32_t above) {
    if (reference & shared::kRayLeaf) {
      const uint32_t first = reference & shared::kRayFirstMask, count = (reference >> shared::kRayCountShift & 7) + 1;
      sound = sound && count <= maxLeaf;
      for (uint32_t i = first; i < first + count; ++i) {
        ++seen[bvh.items[i]];
        sound = sound && contains(box, boxes[bvh.items[i]]);
      }
      return;
    }
    const RayNode& node = bvh.nodes[reference];
    const Box a{node.lowA, node.highA}, b{node.lowB, node.highB};
    sound = sound && contains(box, a) && (node.b == shared::kRayNone || contains(box, b));
    visit(reference, above);
  }
  void visit(uint32_t index, uint32_t above) {
    depth = std::max(depth, above + 1);
    const RayNode& node = bvh.nodes[index];
    child(node.a, {node.lowA, node.highA}, above + 1);
    if (node.b != shared::kRayNone) child(node.b, {node.lowB, node.highB}, above + 1);
  }
};

void expectSound(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth) {
  const Bvh bvh = buildBvh(boxes, maxLeaf, maxDepth);
  Walk walk{bvh, boxes, maxLeaf, std::vector<int>(boxes.size())};
  walk.visit(0, 0);
  EXPECT_TRUE(walk.sound);
  EXPECT_LE(walk.depth, maxDepth);
  EXPECT_TRUE(std::ranges::all_of(walk.seen, [](int times) { return times == 1; }));
  EXPECT_EQ(bvh.levels.size(), walk.depth + 1);
  EXPECT_EQ(bvh.levels.back(), bvh.nodes.size());
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
    for (const uint32_t maxLeaf : {1u, 4u}) expectSound(randomBoxes(count), maxLeaf, 27);
}

TEST(Bvh, StaysShallowForAnyBoxes) {
  std::vector<Box> equal(1000, Box{glm::vec3(1), glm::vec3(2)});
  expectSound(equal, 4, 10);
  std::vector<Box> nested;  // each split by area would separate only the largest boxes
  for (int i = 0; i < 200; ++i) nested.push_back({glm::vec3(0), glm::vec3(std::exp2(static_cast<float>(i % 120)))});
  expectSound(nested, 1, 8);
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

// Nodes of a level lie between levels[i] and levels[i + 1], and their inner children in the next level.
TEST(Bvh, OrdersNodesByLevel) {
  const Bvh bvh = buildBvh(randomBoxes(5000), 4, 44);
  for (size_t level = 0; level + 1 < bvh.levels.size(); ++level)
    for (uint32_t i = bvh.levels[level]; i < bvh.levels[level + 1]; ++i)
      for (const uint32_t child : {bvh.nodes[i].a, bvh.nodes[i].b})
        if (!(child & shared::kRayLeaf)) {
          ASSERT_LT(level + 2, bvh.levels.size());
          EXPECT_GE(child, bvh.levels[level + 1]);
          EXPECT_LT(child, bvh.levels[level + 2]);
        }
}

}  // namespace
}  // namespace latelight::render::test
