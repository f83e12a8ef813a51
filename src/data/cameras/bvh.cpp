#include "data/cameras/bvh.h"

#include <numeric>

namespace latelight::data {

Bvh::Bvh(std::span<const Aabb> boxes) : items_(boxes.size()) {
  constexpr uint32_t kLeaf = 4;
  if (boxes.empty()) return;
  std::iota(items_.begin(), items_.end(), 0u);
  nodes_.push_back({.count = static_cast<uint32_t>(boxes.size())});
  for (size_t at = 0; at < nodes_.size(); ++at) {
    Node node = nodes_[at];
    Aabb centers;
    for (uint32_t i = 0; i < node.count; ++i) {
      const Aabb& box = boxes[items_[node.first + i]];
      node.box.add(box);
      centers.add(box.low + box.high);
    }
    if (node.count > kLeaf) {
      // Split at the median of the centers along the longest axis, so the depth is logarithmic for any boxes.
      const glm::dvec3 extent = centers.high - centers.low;
      const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
      const auto first = items_.begin() + node.first, middle = first + node.count / 2;
      std::nth_element(first, middle, first + node.count, [&](uint32_t a, uint32_t b) {
        return boxes[a].low[axis] + boxes[a].high[axis] < boxes[b].low[axis] + boxes[b].high[axis];
      });
      const auto child = static_cast<uint32_t>(nodes_.size());
      nodes_.push_back({.first = node.first, .count = node.count / 2});
      nodes_.push_back({.first = node.first + node.count / 2, .count = node.count - node.count / 2});
      node.first = child, node.count = 0;
    }
    nodes_[at] = node;
  }
}

}  // namespace latelight::data
