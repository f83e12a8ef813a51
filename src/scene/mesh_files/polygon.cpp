#include "scene/mesh_files/polygon.h"

#include <cmath>
#include <numeric>

namespace latelight::scene::mesh_files {
namespace {

using glm::dvec2;

constexpr size_t kMaxEarCorners = 256;  // cutting ears takes cubic time in the worst case

double crossOf(dvec2 a, dvec2 b, dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool isConvex(std::span<const dvec2> p) {
  for (size_t i = 0; i < p.size(); ++i)
    if (crossOf(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()]) < 0) return false;
  return true;
}

bool isInside(dvec2 a, dvec2 b, dvec2 c, dvec2 p) {
  return crossOf(a, b, p) >= 0 && crossOf(b, c, p) >= 0 && crossOf(c, a, p) >= 0;
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

bool isEar(std::span<const dvec2> p, const std::vector<uint32_t>& left, size_t at) {
  const size_t n = left.size();
  const dvec2 a = p[left[(at + n - 1) % n]], b = p[left[at]], c = p[left[(at + 1) % n]];
  if (crossOf(a, b, c) <= 0) return false;
  for (size_t i = 0; i + 3 < n; ++i) {
    const dvec2 other = p[left[(at + 2 + i) % n]];
    if (other != a && other != b && other != c && isInside(a, b, c, other)) return false;
  }
  return true;
}

void cutEars(std::span<const dvec2> p, std::vector<std::array<uint32_t, 3>>& triangles) {
  std::vector<uint32_t> left(p.size());
  std::iota(left.begin(), left.end(), 0u);
  while (left.size() > 3) {
    size_t ear = 0;
    while (ear < left.size() && !isEar(p, left, ear)) ++ear;
    if (ear == left.size()) ear = 1;  // not simple: a fan's next triangle
    const size_t n = left.size();
    triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<ptrdiff_t>(ear));
  }
  triangles.push_back({left[0], left[1], left[2]});
}

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
  if (count > 3 && count <= kMaxEarCorners) {
    const std::vector<dvec2> flat = projected(corners, polygonNormal(corners));
    if (!isConvex(flat)) return cutEars(flat, triangles);
  }
  for (uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({0, i, i + 1});
}

}  // namespace latelight::scene::mesh_files
