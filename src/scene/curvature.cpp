#include "scene/curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <numeric>

namespace latelight::scene {

namespace {

using Triangle = std::array<uint32_t, 3>;

// The surface without seams: vertices at the same position are one.
struct Surface {
  std::vector<uint32_t> pointOf;    // by vertex of the mesh
  std::vector<glm::dvec3> points;   // meters
  std::vector<Triangle> triangles;  // of points; none is degenerate
};

Surface surfaceOf(const Mesh& mesh, const glm::dmat3& linear) {
  const std::vector<vec3>& positions = mesh.positions;
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto keyOf = [&](uint32_t i) { return std::array{positions[i].x, positions[i].y, positions[i].z}; };
  std::ranges::sort(order, [&](uint32_t a, uint32_t b) { return keyOf(a) < keyOf(b); });
  Surface surface{.pointOf = std::vector<uint32_t>(positions.size()), .points = {}, .triangles = {}};
  for (size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || keyOf(order[i]) != keyOf(order[i - 1]))
      surface.points.push_back(linear * glm::dvec3(positions[order[i]]));
    surface.pointOf[order[i]] = static_cast<uint32_t>(surface.points.size() - 1);
  }
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    Triangle t;
    for (size_t corner = 0; corner < 3; ++corner) t[corner] = surface.pointOf[mesh.indices[i + corner]];
    const glm::dvec3 a = surface.points[t[0]], b = surface.points[t[1]], c = surface.points[t[2]];
    if (glm::length(glm::cross(b - a, c - a)) > 0) surface.triangles.push_back(t);
  }
  return surface;
}

// Edges between points, the lower one first, sorted; one entry per triangle of an edge.
std::vector<std::pair<uint32_t, uint32_t>> edgesOf(const Surface& surface) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles)
    for (size_t i = 0; i < 3; ++i) edges.emplace_back(std::minmax(t[i], t[(i + 1) % 3]));
  std::ranges::sort(edges);
  return edges;
}

// The sums over the triangles around a point.
struct Sums {
  glm::dvec3 bend{0};    // of (cot a + cot b) (x - y) over the edges to y: 4 area times mean curvature times normal
  glm::dvec3 normal{0};  // weighted by area
  double angle = 0, area = 0;  // the mixed area
};

double cotangent(const glm::dvec3& u, const glm::dvec3& v) {
  return glm::dot(u, v) / glm::length(glm::cross(u, v));
}

// Adds a triangle to the sums of its corner `i` (Meyer et al., figure 4).
void add(Sums& sums, const std::array<glm::dvec3, 3>& p, size_t i) {
  const glm::dvec3 &x = p[i], &y = p[(i + 1) % 3], &z = p[(i + 2) % 3];
  const glm::dvec3 toY = y - x, toZ = z - x, normal = glm::cross(toY, toZ);
  const double area = 0.5 * glm::length(normal);
  const double cotAtY = cotangent(x - y, z - y), cotAtZ = cotangent(x - z, y - z);
  sums.normal += normal;
  sums.angle += std::atan2(glm::length(normal), glm::dot(toY, toZ));
  sums.bend -= cotAtZ * toY + cotAtY * toZ;
  const bool obtuseHere = glm::dot(toY, toZ) < 0, obtuse = obtuseHere || cotAtY < 0 || cotAtZ < 0;
  if (obtuse)
    sums.area += obtuseHere ? area / 2 : area / 4;
  else
    sums.area += (glm::dot(toY, toY) * cotAtZ + glm::dot(toZ, toZ) * cotAtY) / 8;
}

glm::dvec2 curvatureOf(const Sums& sums, double handedness) {
  if (!(sums.area > 0)) return glm::dvec2(0);
  const double side = glm::dot(sums.bend, handedness * sums.normal) < 0 ? -1 : 1;
  return {side * glm::length(sums.bend) / (4 * sums.area), (2 * glm::pi<double>() - sums.angle) / sums.area};
}

// Replaces the values of points without a disk around them.
void fillFromNeighbors(std::vector<glm::dvec2>& values, const std::vector<uint8_t>& isDisk,
                       const std::vector<std::pair<uint32_t, uint32_t>>& edges) {
  std::vector<uint32_t> counts(values.size(), 0);
  for (size_t point = 0; point < values.size(); ++point)
    if (!isDisk[point]) values[point] = glm::dvec2(0);
  const auto give = [&](uint32_t from, uint32_t to) {
    if (!isDisk[from] || isDisk[to]) return;
    values[to] += values[from];
    ++counts[to];
  };
  for (size_t i = 0; i < edges.size(); ++i) {
    if (i > 0 && edges[i] == edges[i - 1]) continue;
    give(edges[i].first, edges[i].second);
    give(edges[i].second, edges[i].first);
  }
  for (size_t point = 0; point < values.size(); ++point)
    if (counts[point] > 0) values[point] /= counts[point];
}

}  // namespace

std::vector<glm::vec2> vertexCurvatures(const Mesh& mesh, const glm::dmat3& linear) {
  const Surface surface = surfaceOf(mesh, linear);
  const double handedness = glm::determinant(linear) < 0 ? -1 : 1;
  std::vector<Sums> sums(surface.points.size());
  for (const Triangle& t : surface.triangles) {
    const std::array corners{surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]};
    for (size_t i = 0; i < 3; ++i) add(sums[t[i]], corners, i);
  }
  const std::vector<std::pair<uint32_t, uint32_t>> edges = edgesOf(surface);
  std::vector<uint8_t> isDisk(surface.points.size(), 1);
  for (size_t i = 0; i < edges.size();) {
    size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end - i != 2) isDisk[edges[i].first] = isDisk[edges[i].second] = 0;
    i = end;
  }
  std::vector<glm::dvec2> values;
  for (const Sums& each : sums) values.push_back(curvatureOf(each, handedness));
  fillFromNeighbors(values, isDisk, edges);
  std::vector<glm::vec2> curvatures;
  for (const uint32_t point : surface.pointOf) curvatures.emplace_back(values[point]);
  return curvatures;
}

}  // namespace latelight::scene
