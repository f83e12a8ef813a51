#include "scene/vertex_fans.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "base/parallel.h"

namespace latelight::scene {

namespace {

using glm::dvec3;

// The position and the normal of a vertex, whose zeros have no sign.
using VertexKey = std::tuple<float, float, float, float, float, float>;

VertexKey keyOf(const Mesh& mesh, size_t vertex) {
  const glm::vec3 p = mesh.positions[vertex] + 0.0f, n = mesh.attributes[vertex].normal + 0.0f;
  return {p.x, p.y, p.z, n.x, n.y, n.z};
}

// Returns the group of each vertex. Vertices of one group have equal keys.
std::vector<uint32_t> groupsOf(const Mesh& mesh) {
  std::map<VertexKey, uint32_t> known;
  std::vector<uint32_t> groups;
  for (size_t vertex = 0; vertex < mesh.positions.size(); ++vertex)
    groups.push_back(known.try_emplace(keyOf(mesh, vertex), static_cast<uint32_t>(known.size())).first->second);
  return groups;
}

struct Edges {
  dvec3 b, c;
};

Edges edgesOf(const Mesh& mesh, std::span<const glm::vec3> positions, uint32_t triangle) {
  const uint32_t* corner = &mesh.indices[size_t{3} * triangle];
  const dvec3 a = positions[corner[0]];
  return {dvec3(positions[corner[1]]) - a, dvec3(positions[corner[2]]) - a};
}

// Returns `solve` so that the sum of dot(solve, b) b + dot(solve, c) c over the edges of a fan is the tangent, up to a
// part along the normal: the coefficients with the least sum of squares.
dvec3 solveAlong(const std::vector<Edges>& fan, const dvec3& normal, const dvec3& tangent) {
  glm::dmat3 sum(0);
  for (const Edges& edges : fan) sum += glm::outerProduct(edges.b, edges.b) + glm::outerProduct(edges.c, edges.c);
  const double trace = sum[0][0] + sum[1][1] + sum[2][2];
  constexpr double kAcross = 1e-6;  // the sum is singular if the fan is flat
  sum += kAcross * trace * glm::outerProduct(normal, normal);
  if (!(glm::determinant(sum) > 1e-12 * kAcross * trace * trace * trace)) return dvec3(0);  // a sliver
  return glm::inverse(sum) * (tangent - normal * glm::dot(normal, tangent));
}

// Returns the vector with the length 1, or `otherwise` if it has no direction.
glm::vec3 unitOr(const dvec3& vector, const glm::vec3& otherwise) {
  const double squared = glm::dot(vector, vector);
  return squared > 0 && std::isfinite(squared) ? glm::vec3(vector / std::sqrt(squared)) : otherwise;
}

}  // namespace

VertexFans vertexFans(const Mesh& mesh) {
  const std::vector<uint32_t> groups = groupsOf(mesh);
  const uint32_t count = groups.empty() ? 0 : *std::ranges::max_element(groups) + 1;
  std::vector<std::vector<uint32_t>> around(count);
  for (uint32_t corner = 0; corner < mesh.indices.size(); ++corner) {
    std::vector<uint32_t>& triangles = around[groups[mesh.indices[corner]]];
    if (triangles.empty() || triangles.back() != corner / 3) triangles.push_back(corner / 3);
  }
  VertexFans fans;
  for (size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    fans.first.push_back(static_cast<uint32_t>(fans.triangles.size()));
    const std::vector<uint32_t>& triangles = around[groups[vertex]];
    std::vector<Edges> fan;
    for (const uint32_t triangle : triangles) fan.push_back(edgesOf(mesh, mesh.positions, triangle));
    const dvec3 tangent(glm::vec3(mesh.attributes[vertex].tangent));
    dvec3 along(0);
    if (tangent != dvec3(0)) along = solveAlong(fan, dvec3(mesh.attributes[vertex].normal), tangent);
    for (size_t i = 0; i < fan.size(); ++i)
      fans.triangles.push_back(
          {triangles[i],
           {static_cast<float>(glm::dot(along, fan[i].b)), static_cast<float>(glm::dot(along, fan[i].c))}});
  }
  fans.first.push_back(static_cast<uint32_t>(fans.triangles.size()));
  return fans;
}

std::vector<shared::VertexAttributes> movedAttributes(const Mesh& mesh, const VertexFans& fans,
                                                      std::span<const glm::vec3> positions) {
  std::vector<shared::VertexAttributes> moved = mesh.attributes;
  const auto move = [&](size_t vertex) {
    dvec3 normal(0), tangent(0);
    for (uint32_t i = fans.first[vertex]; i < fans.first[vertex + 1]; ++i) {
      const FanTriangle& fan = fans.triangles[i];
      const Edges edges = edgesOf(mesh, positions, fan.triangle);
      normal += glm::cross(edges.b, edges.c);
      tangent += edges.b * double{fan.along[0]} + edges.c * double{fan.along[1]};
    }
    shared::VertexAttributes& attributes = moved[vertex];
    attributes.normal = unitOr(normal, attributes.normal);
    const dvec3 n(attributes.normal);
    tangent -= n * glm::dot(n, tangent);
    attributes.tangent = glm::vec4(unitOr(tangent, glm::vec3(attributes.tangent)), attributes.tangent.w);
  };
  parallelFor(moved.size(), 1 << 12, [&](size_t begin, size_t end) {
    for (size_t vertex = begin; vertex < end; ++vertex) move(vertex);
  });
  return moved;
}

}  // namespace latelight::scene
