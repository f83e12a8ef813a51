// Builds bounding volume hierarchies on the host, for rays on the device. The result depends only on the boxes, not on
// the number of threads.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "shared/rays.h"

namespace latelight::render {

struct Box {
  glm::vec3 low{std::numeric_limits<float>::infinity()}, high{-std::numeric_limits<float>::infinity()};
  void add(glm::vec3 point) { low = glm::min(low, point), high = glm::max(high, point); }
  void add(const Box& box) { low = glm::min(low, box.low), high = glm::max(high, box.high); }
};

struct Bvh {
  std::vector<shared::RayNode> nodes;  // by level, the root first; empty if there are no boxes
  std::vector<uint32_t> levels;        // index of the first node of each level, and the number of nodes
  std::vector<uint32_t> items;         // indices of the boxes, in the order of the leaves
};

// `maxLeaf`: items per leaf, at most kMaxRayLeaf. `maxDepth`: inner nodes on any path, at least the binary logarithm of
// the number of boxes.
Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth);

}  // namespace latelight::render
