// Checks the structure of a BVH.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "render/rays/bvh.h"

namespace latelight::render::test {

// Vulkan lets devices replace denormal numbers by zero.
inline bool contains(const Box& outer, const Box& inner) {
  const glm::vec3 denormal(std::numeric_limits<float>::min());
  return glm::all(glm::lessThanEqual(outer.low, inner.low + denormal)) &&
         glm::all(glm::greaterThanEqual(outer.high + denormal, inner.high));
}

struct BvhWalk {
  const Bvh& bvh;
  std::span<const Box> boxes;
  uint32_t maxLeaf;
  std::vector<int> visits;  // by item
  uint32_t depth = 0, nodes = 0;
  bool sound = true;

  void child(uint32_t parent, uint32_t reference, const Box& box, uint32_t above) {
    if (reference & shared::kRayLeaf) {
      const uint32_t first = reference & shared::kRayFirstMask, count = (reference >> shared::kRayCountShift & 7) + 1;
      sound = sound && count <= maxLeaf && first + count <= bvh.items.size();
      for (uint32_t i = first; sound && i < first + count; ++i) {
        ++visits[bvh.items[i]];
        sound = sound && contains(box, boxes[bvh.items[i]]);
      }
      return;
    }
    sound = sound && reference > parent && reference < bvh.nodes.size();
    if (!sound) return;
    const shared::RayNode& node = bvh.nodes[reference];
    const Box a{node.lowA, node.highA}, b{node.lowB, node.highB};
    sound = contains(box, a) && (node.b == shared::kRayNone || contains(box, b)) && node.parent == parent;
    visit(reference, above);
  }
  void visit(uint32_t index, uint32_t above) {
    ++nodes;
    depth = std::max(depth, above + 1);
    const shared::RayNode& node = bvh.nodes[index];
    sound = sound && node.refitted == 0;
    child(index, node.a, {node.lowA, node.highA}, above + 1);
    if (node.b != shared::kRayNone) child(index, node.b, {node.lowB, node.highB}, above + 1);
  }
};

// Every item is in one leaf, every box contains its subtree, parents come before their children and are known to them,
// and no path is too deep.
inline void expectSound(const Bvh& bvh, std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth) {
  ASSERT_FALSE(bvh.nodes.empty());
  BvhWalk walk{bvh, boxes, maxLeaf, std::vector<int>(boxes.size())};
  EXPECT_EQ(bvh.nodes[0].parent, shared::kRayNone);
  walk.visit(0, 0);
  EXPECT_TRUE(walk.sound);
  EXPECT_LE(walk.depth, maxDepth);
  EXPECT_EQ(walk.nodes, bvh.nodes.size());
  EXPECT_EQ(bvh.items.size(), boxes.size());
  EXPECT_TRUE(std::ranges::all_of(walk.visits, [](int times) { return times == 1; }));
}

}  // namespace latelight::render::test
