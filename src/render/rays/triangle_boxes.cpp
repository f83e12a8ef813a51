// Triangles are divided before the construction, as if they were several (Karras and Aila 2013, Fast Parallel
// Construction of High-Quality Bounding Volume Hierarchies, section 5.2). They are cut at the planes of a grid over the
// mesh that is halved recursively, coarse planes first. So the boxes of neighboring triangles end at the same planes,
// where nodes can end, too.
#include "render/rays/triangle_boxes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/parallel.h"

namespace latelight::render {

namespace {

constexpr size_t kBoxesAtOnce = 65536;      // per call of a parallel loop
constexpr double kMoreBoxes = 0.2;          // maximum, per triangle
constexpr double kMaxRemainingArea = 0.75;  // of the boxes, if they are to be divided
constexpr int kGridLevels = 20;
constexpr size_t kMaxTriangles = 1 << 20;  // of a mesh that may be divided: this part runs on one thread

using Corners = std::array<glm::vec3, 3>;

Corners cornersOf(const scene::Mesh& mesh, glm::vec3 origin, size_t triangle) {
  Corners corners;
  for (size_t i = 0; i < 3; ++i) corners[i] = mesh.positions[mesh.indices[3 * triangle + i]] - origin;
  return corners;
}

bool isEmpty(const Box& box) {
  return glm::any(glm::greaterThan(box.low, box.high));
}

struct GridPlane {
  int axis = -1;  // -1: none
  float at = 0;
  int level = 0;  // 0: the plane through the center of the grid
};

// Returns the coarsest plane that cuts the box across its longest possible axis.
GridPlane planeOf(const Box& box, const Box& grid) {
  GridPlane best;
  float longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = box.high[axis] - box.low[axis];
    const double cells = 1 << kGridLevels, size = (double{grid.high[axis]} - grid.low[axis]) / cells;
    if (!(size > 0) || !(extent > longest)) continue;
    const auto cellOf = [&](float x) {
      return static_cast<uint32_t>(std::clamp((double{x} - grid.low[axis]) / size, 0.0, cells - 1));
    };
    const uint32_t low = cellOf(box.low[axis]), high = cellOf(box.high[axis]);
    if (low == high) continue;
    const int bit = std::bit_width(low ^ high) - 1;
    const auto at = static_cast<float>(grid.low[axis] + (high >> bit << bit) * size);
    if (!(at > box.low[axis] && at < box.high[axis])) continue;
    longest = extent;
    best = {axis, at, kGridLevels - 1 - bit};
  }
  return best;
}

// The cube root of the area that a division can save, and less for finer planes, which save less elsewhere.
float priorityOf(const Corners& corners, const Box& box, const Box& grid) {
  const GridPlane plane = planeOf(box, grid);
  if (plane.axis < 0) return 0;
  const glm::vec3 projected = 0.5f * glm::abs(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
  const float saved = halfArea(box) - (projected.x + projected.y + projected.z);
  return saved > 0 && std::isfinite(saved) ? std::cbrt(std::ldexp(saved, -plane.level)) : 0.0f;
}

// Bounds of the parts of a triangle on both sides of a plane, in the box of a part. The points where edges cross the
// plane have a margin for their rounding.
std::array<Box, 2> cut(const Corners& corners, const Box& box, const GridPlane& plane) {
  std::array<Box, 2> sides;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3 a(corners[i]), b(corners[(i + 1) % 3]);
    const double fromA = plane.at - a[plane.axis], fromB = plane.at - b[plane.axis];
    if (fromA >= 0) sides[0].add(corners[i]);
    if (fromA <= 0) sides[1].add(corners[i]);
    if ((fromA < 0) == (fromB < 0)) continue;
    const glm::dvec3 crossing = a + (b - a) * (fromA / (fromA - fromB)), margin = 1e-6 * (glm::abs(a) + glm::abs(b));
    for (Box& side : sides) side.add(glm::vec3(crossing - margin)), side.add(glm::vec3(crossing + margin));
  }
  sides[0].high[plane.axis] = std::min(sides[0].high[plane.axis], plane.at);
  sides[1].low[plane.axis] = std::max(sides[1].low[plane.axis], plane.at);
  for (Box& side : sides) side.low = glm::max(side.low, box.low), side.high = glm::min(side.high, box.high);
  return sides;
}

class Divider {
 public:
  Divider(const Box& grid, TriangleBoxes& result) : grid_(grid), result_(result) {}

  // Adds the boxes of a triangle's part in a box, which is cut `cuts` times.
  void add(const Corners& corners, uint32_t triangle, const Box& box, uint32_t cuts) {
    const GridPlane plane = cuts > 0 ? planeOf(box, grid_) : GridPlane{};
    if (plane.axis < 0) return store(triangle, box);
    const std::array<Box, 2> sides = cut(corners, box, plane);
    if (isEmpty(sides[0]) && isEmpty(sides[1])) return store(triangle, box);
    if (isEmpty(sides[0])) return add(corners, triangle, sides[1], cuts - 1);
    if (isEmpty(sides[1])) return add(corners, triangle, sides[0], cuts - 1);
    const double first = glm::length(sides[0].high - sides[0].low), second = glm::length(sides[1].high - sides[1].low);
    const auto ofFirst = static_cast<uint32_t>(std::lround((cuts - 1) * (first / std::max(first + second, 1e-300))));
    add(corners, triangle, sides[0], std::min(ofFirst, cuts - 1));
    add(corners, triangle, sides[1], cuts - 1 - std::min(ofFirst, cuts - 1));
  }

 private:
  void store(uint32_t triangle, const Box& box) {
    result_.boxes.push_back(box);
    result_.triangles.push_back(triangle);
  }

  Box grid_;
  TriangleBoxes& result_;
};

// Returns the factor of priorities at which their integer parts, the numbers of cuts, add up to a budget.
double cutsPerPriority(const std::vector<float>& priorities, double budget) {
  double sum = 0;
  for (const float priority : priorities) sum += priority;
  double low = 0, high = sum > 0 ? 64 * budget / sum : 0;
  for (int i = 0; i < 24; ++i) {
    const double middle = 0.5 * (low + high);
    double cuts = 0;
    for (const float priority : priorities) cuts += std::floor(priority * middle);
    (cuts <= budget ? low : high) = middle;
  }
  return low;
}

TriangleBoxes divided(const scene::Mesh& mesh, glm::vec3 origin, const std::vector<Box>& boxes) {
  Box grid;
  for (const Box& box : boxes) grid.add(box);
  std::vector<float> priorities(boxes.size());
  parallelFor(boxes.size(), kBoxesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) priorities[i] = priorityOf(cornersOf(mesh, origin, i), boxes[i], grid);
  });
  const double scale = cutsPerPriority(priorities, kMoreBoxes * static_cast<double>(boxes.size()));
  TriangleBoxes result;
  Divider divider(grid, result);
  for (size_t i = 0; i < boxes.size(); ++i)
    divider.add(cornersOf(mesh, origin, i), static_cast<uint32_t>(i), boxes[i],
                static_cast<uint32_t>(priorities[i] * scale));
  return result;
}

double areaOf(const std::vector<Box>& boxes) {
  double area = 0;
  for (const Box& box : boxes) area += halfArea(box);
  return area;
}

}  // namespace

TriangleBoxes triangleBoxes(const scene::Mesh& mesh) {
  const glm::vec3 origin = scene::vertexOrigin(mesh);
  TriangleBoxes whole;
  whole.boxes.resize(mesh.indices.size() / 3);
  parallelFor(whole.boxes.size(), kBoxesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (const glm::vec3& corner : cornersOf(mesh, origin, i)) whole.boxes[i].add(corner);
  });
  if (mesh.deformation || whole.boxes.size() > kMaxTriangles) return whole;
  TriangleBoxes parts = divided(mesh, origin, whole.boxes);
  return areaOf(parts.boxes) <= kMaxRemainingArea * areaOf(whole.boxes) ? parts : whole;
}

}  // namespace latelight::render
