// Top-down construction with the surface area heuristic (SAH), evaluated at a few planes per axis (Wald 2007, On Fast
// Construction of SAH-based Bounding Volume Hierarchies). A split that would lead to a tree deeper than allowed is
// replaced by one at the median, which halves the number of items. Large ranges are split on all threads, and the
// subtrees of small ranges are built in parallel. At last, the nodes are brought into the order of their levels.
#include "render/rays/bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "base/parallel.h"

namespace latelight::render {

float halfArea(const Box& box) {
  const glm::vec3 e = box.high - box.low;
  return e.x < 0 ? 0.0f : e.x * e.y + e.y * e.z + e.z * e.x;
}

namespace {

constexpr uint32_t kBins = 16;
// Subtrees of up to kMaxItemsOfTask items are built on one thread, and of fewer if there are few items, so that every
// thread has some.
constexpr uint32_t kMinItemsOfTask = 256, kMaxItemsOfTask = 16384, kMinTasks = 128;
constexpr uint32_t kItemsAtOnce = 16384;  // per call of a parallel loop over a large range
constexpr uint32_t kNodesAtOnce = 8192;   // likewise, over the nodes of a level

// References are as in RayNode.
bool isInner(uint32_t reference) {
  return (reference & shared::kRayLeaf) == 0;
}
uint32_t leafOf(uint32_t first, uint32_t count) {
  return shared::kRayLeaf | (count - 1) << shared::kRayCountShift | first;
}

glm::vec3 centerOf(const Box& box) {
  return 0.5f * box.low + 0.5f * box.high;
}

struct Item {
  Box box;
  uint32_t index;
  uint32_t padding;
};

struct Range {
  uint32_t first = 0, count = 0;
  Box box, centers;  // of the items, and of the centers of their boxes
};

struct Split {
  int axis = -1;  // -1: none
  uint32_t bin = 0;
  float cost = std::numeric_limits<float>::infinity();
};

struct Child {
  Box box;
  uint32_t reference = shared::kRayNone;
};
using TreeNode = std::array<Child, 2>;  // an inner node; references are to nodes of the same list

// A subtree that is built later: child `side` of node `node`.
struct Task {
  uint32_t node = 0, side = 0, depth = 0;
  Range range;
};

// The ranges of a node's children. Both are empty if the range becomes a leaf, and the second one if it has one item.
using Division = std::array<Range, 2>;

// Maps the centers of a range to bins along each axis.
struct Binning {
  glm::vec3 low, scale;
  explicit Binning(const Box& centers) : low(centers.low) {
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centers.high[axis] - centers.low[axis];
      scale[axis] = extent > 0 ? static_cast<float>(kBins) / extent : 0.0f;
      if (!std::isfinite(scale[axis])) scale[axis] = 0;
    }
  }
  uint32_t binOf(glm::vec3 center, int axis) const {
    const float bin = (center[axis] - low[axis]) * scale[axis];
    return bin > 0 ? static_cast<uint32_t>(std::min(bin, static_cast<float>(kBins - 1))) : 0u;
  }
};

struct Bins {
  std::array<std::array<Box, kBins>, 3> boxes;
  std::array<std::array<uint32_t, kBins>, 3> counts{};

  void add(std::span<const Item> items, const Binning& binning) {
    for (const Item& item : items)
      for (int axis = 0; axis < 3; ++axis) {
        const uint32_t bin = binning.binOf(centerOf(item.box), axis);
        boxes[axis][bin].add(item.box);
        ++counts[axis][bin];
      }
  }
  void add(const Bins& other) {
    for (int axis = 0; axis < 3; ++axis)
      for (uint32_t i = 0; i < kBins; ++i) {
        boxes[axis][i].add(other.boxes[axis][i]);
        counts[axis][i] += other.counts[axis][i];
      }
  }

  // Evaluates the planes between the bins of an axis: items of bins up to split.bin are on the first side.
  void addSplits(int axis, Split& best) const {
    std::array<float, kBins> above{};
    Box box;
    uint32_t count = 0;
    for (uint32_t i = kBins - 1; i > 0; --i) {
      box.add(boxes[axis][i]);
      count += counts[axis][i];
      above[i] = count ? halfArea(box) * static_cast<float>(count) : -1;
    }
    box = {};
    count = 0;
    for (uint32_t i = 0; i + 1 < kBins; ++i) {
      box.add(boxes[axis][i]);
      count += counts[axis][i];
      if (count == 0 || above[i + 1] < 0) continue;
      const float cost = halfArea(box) * static_cast<float>(count) + above[i + 1];
      if (cost < best.cost) best = {axis, i, cost};
    }
  }
};

class BvhBuilder {
 public:
  BvhBuilder(std::span<Item> items, std::span<Item> scratch, uint32_t maxLeaf, uint32_t maxDepth)
      : items_(items), scratch_(scratch), maxLeaf_(maxLeaf), maxDepth_(maxDepth) {}

  // Builds the tree of a range below `depth` other nodes, depth first, so that its items stay in the cache.
  void build(const Range& range, uint32_t depth) {
    std::vector<Task> open;
    addNode(partition(range, bestSplit(range), depth), depth, open);
    while (!open.empty()) {
      const Task task = open.back();
      open.pop_back();
      place(task, divide(task), open);
    }
  }

  // Builds the upper part of the tree of all items. Ranges of at most `taskItems` become tasks. The ranges of a level
  // are divided in parallel.
  void buildTop(uint32_t taskItems) {
    const Range whole = boundsOf(0, static_cast<uint32_t>(items_.size()));
    std::vector<Task> open;
    addNode(partition(whole, bestSplit(whole), 0), 0, open);
    while (!open.empty()) {
      std::vector<Task> level;
      for (const Task& task : open) {
        nodes[task.node][task.side].box = task.range.box;
        (isTask(task, taskItems) ? tasks : level).push_back(task);
      }
      std::vector<Division> divisions(level.size());
      parallelFor(level.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) divisions[i] = divide(level[i]);
      });
      open.clear();
      for (size_t i = 0; i < level.size(); ++i) place(level[i], divisions[i], open);
    }
  }

  std::vector<TreeNode> nodes;
  std::vector<Task> tasks;

 private:
  std::span<const Item> itemsOf(const Range& range) const { return items_.subspan(range.first, range.count); }

  static void addTo(Range& range, std::span<const Item> items) {
    for (const Item& item : items) {
      range.box.add(item.box);
      const glm::vec3 center = centerOf(item.box);
      range.centers.add(center);
    }
  }
  Range boundsOf(uint32_t first, uint32_t count) const {
    Range range{.first = first, .count = count, .box = {}, .centers = {}};
    if (count <= kItemsAtOnce) {
      addTo(range, itemsOf(range));
      return range;
    }
    std::vector<Range> parts((count + kItemsAtOnce - 1) / kItemsAtOnce);
    parallelFor(count, kItemsAtOnce, [&](size_t begin, size_t end) {
      addTo(parts[begin / kItemsAtOnce], items_.subspan(first + begin, end - begin));
    });
    for (const Range& part : parts) range.box.add(part.box), range.centers.add(part.centers);
    return range;
  }

  bool isTask(const Task& task, uint32_t taskItems) const {
    return task.range.count <= taskItems && task.range.count > std::max(maxLeaf_, 1u);
  }

  Division divide(const Task& task) {
    const Range& range = task.range;
    if (range.count == 1) return {};
    const Split split = bestSplit(range);
    const float area = halfArea(range.box), leafCost = static_cast<float>(range.count) * area;
    if (range.count <= maxLeaf_ && !(split.cost + shared::kRayNodeCost * area < leafCost)) return {};
    return partition(range, split, task.depth);
  }

  void place(const Task& task, const Division& division, std::vector<Task>& open) {
    Child& child = nodes[task.node][task.side];
    child.box = task.range.box;
    const bool leaf = division[0].count == 0;
    child.reference = leaf ? leafOf(task.range.first, task.range.count) : static_cast<uint32_t>(nodes.size());
    if (!leaf) addNode(division, task.depth, open);
  }

  void addNode(const Division& division, uint32_t depth, std::vector<Task>& open) {
    const auto node = static_cast<uint32_t>(nodes.size());
    nodes.emplace_back();
    for (uint32_t side = 0; side < 2; ++side)
      if (division[side].count) open.push_back({node, side, depth + 1, division[side]});
  }

  Split bestSplit(const Range& range) const {
    const Binning binning(range.centers);
    Bins bins;
    if (range.count <= kItemsAtOnce) {
      bins.add(itemsOf(range), binning);
    } else {
      std::vector<Bins> parts((range.count + kItemsAtOnce - 1) / kItemsAtOnce);
      parallelFor(range.count, kItemsAtOnce, [&](size_t begin, size_t end) {
        parts[begin / kItemsAtOnce].add(items_.subspan(range.first + begin, end - begin), binning);
      });
      for (const Bins& part : parts) bins.add(part);
    }
    Split best;
    for (int axis = 0; axis < 3; ++axis)
      if (binning.scale[axis] > 0) bins.addSplits(axis, best);
    return best;
  }

  static uint32_t depthOf(uint32_t items) { return static_cast<uint32_t>(std::bit_width(items - 1)); }

  // Partitions the items of a range that become children of a node below `depth` others.
  Division partition(const Range& range, const Split& split, uint32_t depth) {
    if (range.count == 1) return {range, {}};
    uint32_t count = 0;
    if (split.axis >= 0) {
      const Binning binning(range.centers);
      count = partition(range,
                        [&](const Item& item) { return binning.binOf(centerOf(item.box), split.axis) <= split.bin; });
    }
    const uint32_t larger = std::max(count, range.count - count);
    if (count == 0 || count == range.count || depth + 1 + depthOf(larger) > maxDepth_) count = splitAtMedian(range);
    return {boundsOf(range.first, count), boundsOf(range.first + count, range.count - count)};
  }

  // Moves the items for which `isFirst` is true to the front of the range. Returns their number.
  template <typename IsFirst>
  uint32_t partition(const Range& range, const IsFirst& isFirst) {
    const std::span<Item> items = items_.subspan(range.first, range.count);
    if (range.count <= kItemsAtOnce)
      return static_cast<uint32_t>(std::partition(items.begin(), items.end(), isFirst) - items.begin());
    std::vector<uint32_t> firsts((range.count + kItemsAtOnce - 1) / kItemsAtOnce);
    parallelFor(range.count, kItemsAtOnce, [&](size_t begin, size_t end) {
      firsts[begin / kItemsAtOnce] =
          static_cast<uint32_t>(std::count_if(items.begin() + begin, items.begin() + end, isFirst));
    });
    uint32_t count = 0;
    for (uint32_t& first : firsts) count += std::exchange(first, count);
    const std::span<Item> moved = scratch_.subspan(range.first, range.count);
    parallelFor(range.count, kItemsAtOnce, [&](size_t begin, size_t end) {
      uint32_t first = firsts[begin / kItemsAtOnce], second = count + static_cast<uint32_t>(begin) - first;
      for (size_t i = begin; i < end; ++i) moved[isFirst(items[i]) ? first++ : second++] = items[i];
    });
    parallelFor(range.count, kItemsAtOnce, [&](size_t begin, size_t end) {
      std::copy(moved.begin() + begin, moved.begin() + end, items.begin() + begin);
    });
    return count;
  }

  uint32_t splitAtMedian(const Range& range) {
    const glm::vec3 extent = range.centers.high - range.centers.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::span<Item> items = items_.subspan(range.first, range.count);
    std::nth_element(items.begin(), items.begin() + range.count / 2, items.end(), [&](const Item& a, const Item& b) {
      const float x = centerOf(a.box)[axis], y = centerOf(b.box)[axis];
      return x != y ? x < y : a.index < b.index;
    });
    return range.count / 2;
  }

  std::span<Item> items_, scratch_;
  uint32_t maxLeaf_, maxDepth_;
};

// Builds the subtrees of the tasks in parallel, and appends them to the nodes.
void buildTasks(BvhBuilder& top, std::span<Item> items, uint32_t maxLeaf, uint32_t maxDepth) {
  std::vector<std::vector<TreeNode>> subtrees(top.tasks.size());
  parallelFor(subtrees.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      BvhBuilder builder(items, {}, maxLeaf, maxDepth);
      builder.build(top.tasks[i].range, top.tasks[i].depth);
      subtrees[i] = std::move(builder.nodes);
    }
  });
  std::vector<uint32_t> bases;
  auto count = static_cast<uint32_t>(top.nodes.size());
  for (size_t i = 0; i < subtrees.size(); ++i) {
    top.nodes[top.tasks[i].node][top.tasks[i].side].reference = count;
    bases.push_back(count);
    count += static_cast<uint32_t>(subtrees[i].size());
  }
  top.nodes.resize(count);
  parallelFor(subtrees.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (size_t node = 0; node < subtrees[i].size(); ++node) {
        TreeNode& moved = top.nodes[bases[i] + node] = subtrees[i][node];
        for (Child& child : moved)
          if (isInner(child.reference)) child.reference += bases[i];
      }
  });
}

// Writes the nodes level by level.
void layOut(const std::vector<TreeNode>& nodes, Bvh& bvh) {
  bvh.nodes.resize(nodes.size());
  bvh.nodes[0].parent = shared::kRayNone;
  uint32_t first = 0;
  for (std::vector<uint32_t> level{0}; !level.empty();) {
    const auto below = first + static_cast<uint32_t>(level.size());
    const auto eachNode = [&](const auto& body) {
      parallelFor(level.size(), kNodesAtOnce, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) body(i, nodes[level[i]], bvh.nodes[first + i]);
      });
    };
    std::vector<uint32_t> children(level.size());  // the number of inner children of earlier nodes of the level
    eachNode([&](size_t i, const TreeNode& node, shared::RayNode&) {
      children[i] = uint32_t{isInner(node[0].reference)} + uint32_t{isInner(node[1].reference)};
    });
    uint32_t count = 0;
    for (uint32_t& child : children) count += std::exchange(child, count);
    std::vector<uint32_t> next(count);
    eachNode([&](size_t i, const TreeNode& node, shared::RayNode& target) {
      uint32_t child = children[i];
      const auto placed = [&](uint32_t reference) {
        if (!isInner(reference)) return reference;
        next[child] = reference;
        bvh.nodes[below + child].parent = first + static_cast<uint32_t>(i);
        return below + child++;
      };
      const uint32_t a = placed(node[0].reference), b = placed(node[1].reference);
      target = {.lowA = node[0].box.low,
                .a = a,
                .highA = node[0].box.high,
                .b = b,
                .lowB = node[1].box.low,
                .parent = target.parent,
                .highB = node[1].box.high};
    });
    first = below;
    level = std::move(next);
  }
}

}  // namespace

Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeaf, uint32_t maxDepth) {
  Bvh bvh;
  if (boxes.empty()) return bvh;
  std::vector<Item> items(boxes.size()), scratch(boxes.size() > kItemsAtOnce ? boxes.size() : 0);
  parallelFor(boxes.size(), kItemsAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) items[i] = {boxes[i], static_cast<uint32_t>(i), 0};
  });
  BvhBuilder top(items, scratch, maxLeaf, maxDepth);
  top.buildTop(std::clamp(static_cast<uint32_t>(boxes.size()) / kMinTasks, kMinItemsOfTask, kMaxItemsOfTask));
  buildTasks(top, items, maxLeaf, maxDepth);
  bvh.items.resize(items.size());
  parallelFor(items.size(), kItemsAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) bvh.items[i] = items[i].index;
  });
  layOut(top.nodes, bvh);
  return bvh;
}

double sahCost(const Bvh& bvh) {
  double cost = 0, rootArea = 0;
  for (const shared::RayNode& node : bvh.nodes) {
    const bool hasB = node.b != shared::kRayNone;
    Box both{node.lowA, node.highA};
    if (hasB) both.add(Box{node.lowB, node.highB});
    const double area = halfArea(both);
    if (rootArea == 0) rootArea = area;
    cost += double{shared::kRayNodeCost} * area;
    const auto addLeaf = [&](uint32_t reference, const Box& box) {
      if (!isInner(reference)) cost += ((reference >> shared::kRayCountShift & 7) + 1) * double{halfArea(box)};
    };
    addLeaf(node.a, {node.lowA, node.highA});
    if (hasB) addLeaf(node.b, {node.lowB, node.highB});
  }
  return rootArea > 0 ? cost / rootArea : 0;
}

}  // namespace latelight::render
