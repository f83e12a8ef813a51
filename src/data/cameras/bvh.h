// A bounding volume hierarchy (BVH) over items with axis-aligned bounding boxes. It uses doubles and no fused
// operations, so results are the same on every machine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

namespace latelight::data {

struct Aabb {
  glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  glm::dvec3 center() const { return (low + high) * 0.5; }
  double radius() const { return glm::length(high - low) * 0.5; }
  void add(glm::dvec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
  void add(const Aabb& box) { low = glm::min(low, box.low), high = glm::max(high, box.high); }
  // The distance of a point from the box; 0 inside.
  double distance(glm::dvec3 p) const { return glm::length(glm::max(glm::dvec3(0), glm::max(low - p, p - high))); }
  // Returns true if the ray from `origin` in the direction 1 / `inverse` hits the box (slab test). A ray in the plane
  // of a face counts as a hit.
  bool meets(glm::dvec3 origin, glm::dvec3 inverse) const {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - origin[axis]) * inverse[axis], b = (high[axis] - origin[axis]) * inverse[axis];
      if (std::isnan(a) || std::isnan(b)) continue;  // 0 times infinity: the ray is in a face's plane
      enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave * (1 + 4 * std::numeric_limits<double>::epsilon());
  }
};

class Bvh {
 public:
  explicit Bvh(std::span<const Aabb> boxes);

  Aabb bounds() const { return nodes_.empty() ? Aabb{} : nodes_[0].box; }
  // Calls leaf(item) for every item below nodes for which enter(box) is true.
  template <typename Enter, typename Leaf>
  void visit(const Enter& enter, const Leaf& leaf) const {
    std::vector<uint32_t> open;
    if (!nodes_.empty()) open.push_back(0);
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      if (!enter(node.box)) continue;
      for (uint32_t i = 0; i < node.count; ++i) leaf(items_[node.first + i]);
      if (node.count == 0) open.push_back(node.first + 1), open.push_back(node.first);
    }
  }

 private:
  struct Node {
    Aabb box;
    uint32_t first = 0, count = 0;  // range of items; if it is empty, the children are nodes `first` and `first` + 1
  };
  std::vector<Node> nodes_;
  std::vector<uint32_t> items_;
};

}  // namespace latelight::data
