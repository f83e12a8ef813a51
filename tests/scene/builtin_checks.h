// Checks for every built-in mesh; a failure names the mesh.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <unordered_map>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

struct TriangleShares {
  double degenerate = 0;  // share of triangles whose area is 0 except for rounding
  double against = 0;     // share of triangles whose normal differs from a vertex normal by more than 90 degrees
};

inline TriangleShares triangleShares(const Mesh& mesh) {
  size_t degenerate = 0, against = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const uint32_t* t = &mesh.indices[i];
    const glm::dvec3 a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    // Returns true if the triangle's height is within a few rounding errors of its coordinates.
    const double coordinate = std::max({glm::length(a), glm::length(b), glm::length(c)});
    if (glm::length(n) <= longest * coordinate * 5e-7) {
      ++degenerate;
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      if (glm::dot(n, glm::dvec3(mesh.attributes[t[k]].normal)) <= 0) {
        ++against;
        break;
      }
    }
  }
  const double count = std::max<double>(1, double(mesh.indices.size() / 3));
  return {double(degenerate) / count, double(against) / count};
}

inline void checkVertices(const Mesh& mesh, bool needsTangents) {
  ASSERT_EQ(mesh.positions.size(), mesh.attributes.size()) << mesh.name;
  ASSERT_TRUE(mesh.extras.empty() || mesh.extras.size() == mesh.positions.size()) << mesh.name;
  double worstNormal = 0, worstTangent = 0, worstAngle = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const shared::VertexAttributes& a = mesh.attributes[i];
    ASSERT_TRUE(std::isfinite(glm::dot(mesh.positions[i], vec3(1)) + a.uv0.x + a.uv0.y)) << mesh.name << " " << i;
    ASSERT_TRUE(glm::all(glm::greaterThanEqual(mesh.positions[i], mesh.boundsMin)) &&
                glm::all(glm::lessThanEqual(mesh.positions[i], mesh.boundsMax)))
        << mesh.name << " " << i;
    worstNormal = std::max(worstNormal, std::abs(double(glm::length(a.normal)) - 1));
    if (!needsTangents) continue;
    const vec3 t(a.tangent);
    worstTangent = std::max(worstTangent, std::abs(double(glm::length(t)) - 1));
    worstAngle = std::max(worstAngle, std::abs(double(glm::dot(t, a.normal))));
    ASSERT_EQ(std::abs(a.tangent.w), 1.0f) << mesh.name << " " << i;
  }
  EXPECT_LT(worstNormal, 1e-5) << mesh.name;
  EXPECT_LT(worstTangent, 1e-5) << mesh.name;
  EXPECT_LT(worstAngle, 1e-4) << mesh.name;
}

// Checks that indices and vertices of every mesh are valid, and that front faces are on the side of their normals,
// except for these shares of the triangles.
inline void checkMeshes(const Scene& scene, double degenerate = 0, double against = 0) {
  std::vector<bool> mapped(scene.meshes.size());
  for (const Instance& instance : scene.instances)
    if (scene.materials[instance.material].slots[shared::kTextureNormal].texture >= 0) mapped[instance.mesh] = true;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    ASSERT_FALSE(mesh.indices.empty()) << mesh.name;
    ASSERT_EQ(mesh.indices.size() % 3, 0u) << mesh.name;
    ASSERT_LT(*std::max_element(mesh.indices.begin(), mesh.indices.end()), mesh.positions.size()) << mesh.name;
    checkVertices(mesh, mapped[i]);
    const TriangleShares shares = triangleShares(mesh);
    EXPECT_LE(shares.degenerate, degenerate) << mesh.name;
    EXPECT_LE(shares.against, against) << mesh.name;
  }
}

// If vertices at equal positions are merged, every edge has as many triangles on one side as on the other, so the
// surface is closed.
inline size_t openEdges(const Mesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> places;
  std::vector<uint32_t> weld;
  for (const vec3& p : mesh.positions) {
    const std::array<float, 3> key{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 is 0
    weld.push_back(places.try_emplace(key, uint32_t(places.size())).first->second);
  }
  std::unordered_map<uint64_t, int> balance;
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const uint32_t a = weld[mesh.indices[i]], b = weld[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (a == b) continue;
    balance[uint64_t{std::min(a, b)} << 32 | std::max(a, b)] += a < b ? 1 : -1;
  }
  return size_t(std::count_if(balance.begin(), balance.end(), [](const auto& e) { return e.second != 0; }));
}

inline void checkWatertight(const Mesh& mesh) {
  EXPECT_EQ(openEdges(mesh), 0u) << mesh.name;
}

}  // namespace latelight::scene
