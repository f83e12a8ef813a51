// Bounding volume hierarchies for rays on the device, and their construction on the host. The result depends only on
// the boxes, not on the number of threads.
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

float halfArea(const Box& box);  // half of the surface's; 0 if the box is empty

struct Bvh {
  std::vector<shared::RayNode> nodes;  // the root first, parents before children; empty if there are no boxes
  std::vector<uint32_t> items;         // indices of the boxes, in the order of the leaves
};

// `maxLeaf`: items per leaf, at most kMaxRayLeaf. `maxDepth`: inner nodes on any path, at least the binary logarithm of
// the number of boxes.
Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth);

// Returns the cost by the surface area heuristic: the mean number of items that are tested, plus shared::kRayNodeCost
// per visited node, for rays through the box of the root.
double sahCost(const Bvh& bvh);

}  // namespace latelight::render
