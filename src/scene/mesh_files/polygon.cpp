// Ear clipping (Meisters, "Polygons have ears", 1975) in O(n log n) steps for usual polygons.
//
// The ear with the smallest index is cut first. A corner stays an ear until a neighbor is cut, because no corners are
// added. A convex corner that is no ear has another corner in its triangle, its blocker, and is tested again only when
// a neighbor or the blocker has been cut. A tree of boxes over the positions of the corners finds blockers. It chooses
// among several at random, because the expected number of tests is then logarithmic for any order of cuts. The choice
// does not change the triangles.
#include "scene/mesh_files/polygon.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <random>
#include <utility>

namespace latelight::scene::mesh_files {
namespace {

using glm::dvec2;

constexpr uint32_t kNone = ~0u;

double crossOf(dvec2 a, dvec2 b, dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool isFinite(dvec2 p) {
  return std::isfinite(p.x) && std::isfinite(p.y);
}

bool isConvex(std::span<const dvec2> p) {
  for (size_t i = 0; i < p.size(); ++i)
    if (crossOf(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()]) < 0) return false;
  return true;
}

// Returns the corners without the coordinate along which the normal is longest, counterclockwise.
std::vector<dvec2> projected(std::span<const vec3> corners, glm::dvec3 normal) {
  const glm::dvec3 size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<dvec2> flat(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    flat[i] = {corners[i][u], corners[i][v]};
    if (normal[axis] < 0) std::swap(flat[i].x, flat[i].y);
  }
  return flat;
}

struct Triangle2 {
  dvec2 a, b, c;  // counterclockwise
  bool isCorner(dvec2 p) const { return p == a || p == b || p == c; }
  bool contains(dvec2 p) const { return crossOf(a, b, p) >= 0 && crossOf(b, c, p) >= 0 && crossOf(c, a, p) >= 0; }
  // False if the box is outside of the triangle's own box or of one of its edges. Rounding is monotonic, so contains()
  // is false for all points of the box that an edge excludes.
  bool mayTouch(dvec2 low, dvec2 high) const {
    const dvec2 least = glm::min(glm::min(a, b), c), greatest = glm::max(glm::max(a, b), c);
    if (low.x > greatest.x || low.y > greatest.y || high.x < least.x || high.y < least.y) return false;
    const auto isBeyond = [&](dvec2 from, dvec2 to) {
      return crossOf(from, to, {to.y > from.y ? low.x : high.x, to.x > from.x ? high.y : low.y}) < 0;
    };
    return !isBeyond(a, b) && !isBeyond(b, c) && !isBeyond(c, a);
  }
};

// The distinct positions of the corners that are left, in a balanced binary tree of bounding boxes.
class PositionTree {
 public:
  // Positions that are not finite are in no triangle, and not in the tree.
  explicit PositionTree(std::span<const dvec2> corners) : positionOf_(corners.size(), kNone) {
    std::vector<uint32_t> order(corners.size());
    std::iota(order.begin(), order.end(), 0u);
    std::erase_if(order, [&](uint32_t corner) { return !isFinite(corners[corner]); });
    const auto key = [&](uint32_t corner) { return std::pair(corners[corner].x, corners[corner].y); };
    std::ranges::sort(order, {}, key);
    for (const uint32_t corner : order) {
      if (points_.empty() || points_.back().at != corners[corner]) points_.push_back({corners[corner]});
      ++points_.back().corners;
      positionOf_[corner] = static_cast<uint32_t>(points_.size() - 1);
    }
    slots_.resize(points_.size());
    std::iota(slots_.begin(), slots_.end(), 0u);
    if (!points_.empty()) build(0, static_cast<uint32_t>(points_.size()), kNone);
  }

  // Returns the index of the position of a corner that has not been removed, or kNone.
  uint32_t positionOf(uint32_t corner) const { return positionOf_[corner]; }

  // Removes a corner. Returns true if no other one has its position.
  bool remove(uint32_t corner) {
    const uint32_t position = positionOf_[corner];
    if (position == kNone || --points_[position].corners > 0) return false;
    for (uint32_t node = points_[position].leaf; node != kNone; node = nodes_[node].parent) --nodes_[node].positions;
    return true;
  }

  // Returns a position in the triangle that is not one of its corners, or kNone.
  uint32_t find(const Triangle2& triangle) {
    if (nodes_.empty()) return kNone;
    stack_.assign(1, 0);
    while (!stack_.empty()) {
      const Node& node = nodes_[stack_.back()];
      stack_.pop_back();
      if (node.positions == 0 || !triangle.mayTouch(node.low, node.high)) continue;
      if (node.second != kNone) {
        const bool swaps = random_() % 2 == 1;
        stack_.push_back(swaps ? node.first : node.second);
        stack_.push_back(swaps ? node.second : node.first);
        continue;
      }
      for (uint32_t i = node.begin; i < node.end; ++i) {
        const Point& point = points_[slots_[i]];
        if (point.corners > 0 && triangle.contains(point.at) && !triangle.isCorner(point.at)) return slots_[i];
      }
    }
    return kNone;
  }

 private:
  static constexpr uint32_t kLeafSize = 8;

  struct Point {
    dvec2 at;
    uint32_t corners = 0;  // that have this position and are left
    uint32_t leaf = kNone;
  };
  struct Node {
    dvec2 low{0}, high{0};
    uint32_t parent = kNone, first = kNone, second = kNone;  // no children: a leaf
    uint32_t begin = 0, end = 0;                             // its positions in slots_
    uint32_t positions = 0;                                  // that are left
  };

  uint32_t build(uint32_t begin, uint32_t end, uint32_t parent) {
    const auto index = static_cast<uint32_t>(nodes_.size());
    Node node{.parent = parent, .begin = begin, .end = end, .positions = end - begin};
    node.low = node.high = points_[slots_[begin]].at;
    for (uint32_t i = begin; i < end; ++i) {
      node.low = glm::min(node.low, points_[slots_[i]].at);
      node.high = glm::max(node.high, points_[slots_[i]].at);
    }
    nodes_.push_back(node);
    if (end - begin <= kLeafSize) {
      for (uint32_t i = begin; i < end; ++i) points_[slots_[i]].leaf = index;
      return index;
    }
    const int axis = node.high.x - node.low.x >= node.high.y - node.low.y ? 0 : 1;
    const uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(slots_.begin() + begin, slots_.begin() + middle, slots_.begin() + end,
                     [&](uint32_t a, uint32_t b) { return points_[a].at[axis] < points_[b].at[axis]; });
    const uint32_t first = build(begin, middle, index), second = build(middle, end, index);
    nodes_[index].first = first, nodes_[index].second = second;
    return index;
  }

  std::vector<uint32_t> positionOf_;  // by corner
  std::vector<Point> points_;
  std::vector<uint32_t> slots_;  // indices of points_, in the order of the leaves
  std::vector<Node> nodes_;
  std::vector<uint32_t> stack_;  // of find()
  std::minstd_rand random_;
};

class EarClipper {
 public:
  explicit EarClipper(std::span<const dvec2> corners)
      : p_(corners), tree_(corners), corners_(corners.size()), waiting_(corners.size(), kNone) {
    const auto count = static_cast<uint32_t>(corners.size());
    for (uint32_t i = 0; i < count; ++i) corners_[i] = {.previous = (i + count - 1) % count, .next = (i + 1) % count};
    for (uint32_t i = 0; i < count; ++i) test(i);
  }

  void run(std::vector<std::array<uint32_t, 3>>& triangles) {
    uint32_t first = 0;  // the corner with the smallest index
    for (size_t left = p_.size(); left > 3; --left) {
      uint32_t ear = nextEar();
      if (ear == kNone) ear = corners_[first].next;  // not simple: a fan's next triangle
      const auto [previous, next] = std::pair(corners_[ear].previous, corners_[ear].next);
      triangles.push_back({previous, ear, next});
      if (ear == first) first = next;
      cut(ear);
    }
    triangles.push_back({first, corners_[first].next, corners_[first].previous});
  }

 private:
  struct Corner {
    uint32_t previous, next;
    uint32_t blocker = kNone;  // the position that keeps it from being an ear
    bool isEar = false, isCut = false;
  };
  struct Waiting {
    uint32_t corner, next;
  };

  // Entries of corners that are no ears any more are dropped.
  uint32_t nextEar() {
    while (!ears_.empty()) {
      const uint32_t corner = ears_.top();
      ears_.pop();
      if (corners_[corner].isEar && !corners_[corner].isCut) return corner;
    }
    return kNone;
  }

  void cut(uint32_t ear) {
    Corner& corner = corners_[ear];
    corner.isCut = true;
    corners_[corner.previous].next = corner.next;
    corners_[corner.next].previous = corner.previous;
    const bool isLast = tree_.remove(ear);
    test(corner.previous);
    test(corner.next);
    if (!isLast) return;
    const uint32_t position = tree_.positionOf(ear);
    for (uint32_t at = std::exchange(waiting_[position], kNone); at != kNone; at = waits_[at].next) {
      const uint32_t blocked = waits_[at].corner;
      if (!corners_[blocked].isCut && corners_[blocked].blocker == position) test(blocked);
    }
  }

  void test(uint32_t at) {
    Corner& corner = corners_[at];
    const Triangle2 triangle{p_[corner.previous], p_[at], p_[corner.next]};
    corner.isEar = false;
    corner.blocker = kNone;
    if (crossOf(triangle.a, triangle.b, triangle.c) <= 0) return;
    if (isFinite(triangle.a) && isFinite(triangle.b) && isFinite(triangle.c)) corner.blocker = tree_.find(triangle);
    corner.isEar = corner.blocker == kNone;
    if (corner.isEar) return ears_.push(at);
    waits_.push_back({at, waiting_[corner.blocker]});
    waiting_[corner.blocker] = static_cast<uint32_t>(waits_.size() - 1);
  }

  std::span<const dvec2> p_;
  PositionTree tree_;
  std::vector<Corner> corners_;
  std::vector<uint32_t> waiting_;  // by position: the last one of waits_ that it blocks, or kNone
  std::vector<Waiting> waits_;     // chains of corners that a position blocks
  std::priority_queue<uint32_t, std::vector<uint32_t>, std::greater<>> ears_;
};

}  // namespace

glm::dvec3 polygonNormal(std::span<const vec3> corners) {
  glm::dvec3 normal(0);
  const glm::dvec3 first = corners[0];
  for (size_t i = 1; i + 1 < corners.size(); ++i)
    normal += glm::cross(glm::dvec3(corners[i]) - first, glm::dvec3(corners[i + 1]) - first);
  return normal;
}

void triangulate(std::span<const vec3> corners, std::vector<std::array<uint32_t, 3>>& triangles) {
  const auto count = static_cast<uint32_t>(corners.size());
  if (count < 3) return;
  if (count > 3) {
    const std::vector<dvec2> flat = projected(corners, polygonNormal(corners));
    if (!isConvex(flat)) return EarClipper(flat).run(triangles);
  }
  for (uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({0, i, i + 1});
}

}  // namespace latelight::scene::mesh_files
