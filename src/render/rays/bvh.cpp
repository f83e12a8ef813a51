// Top-down construction with the surface area heuristic (SAH), evaluated at a few planes per axis (Wald 2007, On Fast
// Construction of SAH-based Bounding Volume Hierarchies). A split that would lead to a tree deeper than allowed is
// replaced by one at the median, which halves the number of items. The upper levels are built on one thread until the
// ranges are small, and the subtrees of these ranges in parallel. At last, the nodes are brought into the order of
// their levels, so that a refit can process one level after the other, from the last to the first.
#include "render/rays/bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "base/parallel.h"

namespace latelight::render {

namespace {

constexpr uint32_t kBins = 16;
constexpr uint32_t kRangeOfTask = 16384;  // items below which a subtree is built on one thread
constexpr float kCostOfNode = 1.0f;       // relative to that of an item

float halfArea(const Box& box) {
  const glm::vec3 e = box.high - box.low;
  return e.x < 0 ? 0.0f : e.x * e.y + e.y * e.z + e.z * e.x;
}

struct Range {
  uint32_t first = 0, count = 0;
};

struct Split {
  int axis = -1;  // -1: none is better than a leaf
  uint32_t bin = 0;
  float cost = std::numeric_limits<float>::infinity();
};

struct TreeNode {  // an inner node: references are as in RayNode, to nodes of the same list
  std::array<Box, 2> boxes;
  std::array<uint32_t, 2> children{shared::kRayNone, shared::kRayNone};
};

// A subtree that is built later: child `side` of node `node`.
struct Task {
  uint32_t node = 0, side = 0, depth = 0;
  Range range;
};

class BvhBuilder {
 public:
  BvhBuilder(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth, std::vector<uint32_t>& items)
      : boxes_(boxes), items_(items), maxLeaf_(maxLeaf), maxDepth_(maxDepth) {}

  // Builds the tree of a range below `depth` other nodes. Ranges of at most `taskItems` become tasks.
  void build(Range range, uint32_t depth, uint32_t taskItems) {
    nodes.emplace_back();
    const std::array<Range, 2> halves = split(range, depth);
    std::vector<Task> open{{0, 0, depth + 1, halves[0]}};
    if (halves[1].count) open.push_back({0, 1, depth + 1, halves[1]});
    while (!open.empty()) {
      const Task task = open.back();
      open.pop_back();
      place(task, taskItems, open);
    }
  }

  std::vector<TreeNode> nodes;
  std::vector<Task> tasks;

 private:
  Box boundsOf(Range range) const {
    Box box;
    for (uint32_t i = 0; i < range.count; ++i) box.add(boxes_[items_[range.first + i]]);
    return box;
  }

  void place(const Task& task, uint32_t taskItems, std::vector<Task>& open) {
    nodes[task.node].boxes[task.side] = boundsOf(task.range);
    if (task.range.count <= maxLeaf_ && isLeaf(task.range)) {
      nodes[task.node].children[task.side] =
          shared::kRayLeaf | (task.range.count - 1) << shared::kRayCountShift | task.range.first;
    } else if (task.range.count <= taskItems) {
      tasks.push_back(task);
    } else {
      const auto child = static_cast<uint32_t>(nodes.size());
      nodes[task.node].children[task.side] = child;
      nodes.emplace_back();
      const std::array<Range, 2> halves = split(task.range, task.depth);
      for (uint32_t side = 0; side < 2; ++side) open.push_back({child, side, task.depth + 1, halves[side]});
    }
  }

  // Returns true if no split of a small range reduces the expected time of a ray.
  bool isLeaf(Range range) const {
    if (range.count == 1) return true;
    const Box box = boundsOf(range);
    const float leafCost = static_cast<float>(range.count) * halfArea(box);
    return !(bestSplit(range).cost + kCostOfNode * halfArea(box) < leafCost);
  }

  static constexpr float binScale(float low, float high) {
    return high > low ? static_cast<float>(kBins) / (high - low) : 0.0f;
  }
  static uint32_t binOf(float center, float low, float scale) {
    const float bin = (center - low) * scale;
    return bin > 0 ? std::min(static_cast<uint32_t>(std::min(bin, 1e6f)), kBins - 1) : 0u;
  }
  static glm::vec3 centerOf(const Box& box) { return 0.5f * box.low + 0.5f * box.high; }

  Box centersOf(Range range) const {
    Box centers;
    for (uint32_t i = 0; i < range.count; ++i) centers.add(centerOf(boxes_[items_[range.first + i]]));
    return centers;
  }

  Split bestSplit(Range range) const {
    const Box centers = centersOf(range);
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      const float scale = binScale(centers.low[axis], centers.high[axis]);
      if (scale == 0 || !(scale < std::numeric_limits<float>::infinity())) continue;
      std::array<Box, kBins> bins;
      std::array<uint32_t, kBins> counts{};
      for (uint32_t i = 0; i < range.count; ++i) {
        const Box& box = boxes_[items_[range.first + i]];
        const uint32_t bin = binOf(centerOf(box)[axis], centers.low[axis], scale);
        bins[bin].add(box);
        ++counts[bin];
      }
      addSplits(bins, counts, axis, best);
    }
    return best;
  }

  // Evaluates the planes between the bins: items of bins up to split.bin are on the first side.
  static void addSplits(const std::array<Box, kBins>& bins, const std::array<uint32_t, kBins>& counts, int axis,
                        Split& best) {
    std::array<float, kBins> above{};
    Box box;
    uint32_t count = 0;
    for (uint32_t i = kBins - 1; i > 0; --i) {
      box.add(bins[i]);
      count += counts[i];
      above[i] = count ? halfArea(box) * static_cast<float>(count) : -1;
    }
    box = {};
    count = 0;
    for (uint32_t i = 0; i + 1 < kBins; ++i) {
      box.add(bins[i]);
      count += counts[i];
      if (count == 0 || above[i + 1] < 0) continue;
      const float cost = halfArea(box) * static_cast<float>(count) + above[i + 1];
      if (cost < best.cost) best = {axis, i, cost};
    }
  }

  static uint32_t depthOf(uint32_t items) { return static_cast<uint32_t>(std::bit_width(items - 1)); }

  // Partitions the items of a range that become children of a node below `depth` others.
  std::array<Range, 2> split(Range range, uint32_t depth) {
    if (range.count == 1) return {range, {}};
    const auto first = items_.begin() + range.first, end = first + range.count;
    const Split best = bestSplit(range);
    auto middle = first;
    if (best.axis >= 0) {
      const Box centers = centersOf(range);
      const float low = centers.low[best.axis], scale = binScale(low, centers.high[best.axis]);
      middle = std::stable_partition(
          first, end, [&](uint32_t item) { return binOf(centerOf(boxes_[item])[best.axis], low, scale) <= best.bin; });
    }
    const auto larger = static_cast<uint32_t>(std::max(middle - first, end - middle));
    if (middle == first || middle == end || depth + 1 + depthOf(larger) > maxDepth_) middle = splitAtMedian(first, end);
    const auto count = static_cast<uint32_t>(middle - first);
    return {Range{range.first, count}, Range{range.first + count, range.count - count}};
  }

  using Iterator = std::vector<uint32_t>::iterator;
  Iterator splitAtMedian(Iterator first, Iterator end) const {
    Box centers;
    for (auto i = first; i != end; ++i) centers.add(centerOf(boxes_[*i]));
    const glm::vec3 extent = centers.high - centers.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto middle = first + (end - first) / 2;
    std::nth_element(first, middle, end, [&](uint32_t a, uint32_t b) {
      const float x = centerOf(boxes_[a])[axis], y = centerOf(boxes_[b])[axis];
      return x != y ? x < y : a < b;
    });
    return middle;
  }

  std::span<const Box> boxes_;
  std::vector<uint32_t>& items_;
  uint32_t maxLeaf_, maxDepth_;
};

bool isInner(uint32_t reference) {
  return (reference & shared::kRayLeaf) == 0;
}

// Appends a subtree to the nodes. Its root becomes the child of the task.
void append(std::vector<TreeNode>& nodes, const std::vector<TreeNode>& subtree, const Task& task) {
  const auto base = static_cast<uint32_t>(nodes.size());
  nodes[task.node].children[task.side] = base;
  for (const TreeNode& node : subtree) {
    TreeNode& moved = nodes.emplace_back(node);
    for (uint32_t& child : moved.children)
      if (isInner(child)) child += base;
  }
}

// Writes the nodes level by level.
void layOut(const std::vector<TreeNode>& nodes, Bvh& bvh) {
  bvh.nodes.reserve(nodes.size());
  std::vector<uint32_t> level{0}, next;
  while (!level.empty()) {
    bvh.levels.push_back(static_cast<uint32_t>(bvh.nodes.size()));
    next.clear();
    const auto below = static_cast<uint32_t>(bvh.nodes.size() + level.size());
    const auto placed = [&](uint32_t child) {
      if (!isInner(child)) return child;
      next.push_back(child);
      return below + static_cast<uint32_t>(next.size()) - 1;
    };
    for (const uint32_t index : level) {
      const TreeNode& node = nodes[index];
      const uint32_t a = placed(node.children[0]), b = placed(node.children[1]);
      bvh.nodes.push_back({.lowA = node.boxes[0].low,
                           .a = a,
                           .highA = node.boxes[0].high,
                           .b = b,
                           .lowB = node.boxes[1].low,
                           .highB = node.boxes[1].high});
    }
    std::swap(level, next);
  }
  bvh.levels.push_back(static_cast<uint32_t>(bvh.nodes.size()));
}

}  // namespace

Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth) {
  Bvh bvh;
  if (boxes.empty()) return bvh;
  bvh.items.resize(boxes.size());
  std::iota(bvh.items.begin(), bvh.items.end(), 0u);
  BvhBuilder top(boxes, maxLeaf, maxDepth, bvh.items);
  top.build({0, static_cast<uint32_t>(boxes.size())}, 0, kRangeOfTask);
  std::vector<std::vector<TreeNode>> subtrees(top.tasks.size());
  parallelFor(subtrees.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      BvhBuilder builder(boxes, maxLeaf, maxDepth, bvh.items);
      builder.build(top.tasks[i].range, top.tasks[i].depth, 0);
      subtrees[i] = std::move(builder.nodes);
    }
  });
  for (size_t i = 0; i < subtrees.size(); ++i) append(top.nodes, subtrees[i], top.tasks[i]);
  layOut(top.nodes, bvh);
  return bvh;
}

}  // namespace latelight::render
