// Clusters (meshlets) compared with their triangles: every triangle lies in the bounding sphere, and is back-facing
// from every point for which the normal cone states so.
#include "scene/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "scene/builtin/builtin.h"
#include "scene/load/load.h"

namespace latelight::scene {
namespace {

constexpr float kRounding = 1e-5f;

struct Corners {
  vec3 a, b, c;
};
// With the cluster's own vertices.
std::vector<Corners> trianglesOf(const Mesh& mesh, const Clusters& all, size_t cluster) {
  const size_t first = shared::kClusterTriangles * cluster;
  std::vector<Corners> triangles;
  for (size_t i = first; i < std::min(all.triangles.size(), first + shared::kClusterTriangles); ++i) {
    const auto corner = [&](uint32_t j) {
      const uint32_t vertex = shared::clusterCorner(all.triangles[i], j);
      EXPECT_LT(vertex, all.clusters[cluster].vertices);
      return mesh.positions[all.vertices[all.clusters[cluster].firstVertex + vertex]];
    };
    triangles.push_back({corner(0), corner(1), corner(2)});
  }
  return triangles;
}

// A mesh with only positions and triangles.
Mesh meshOf(const std::vector<vec3>& positions, const std::vector<uint32_t>& indices) {
  Mesh mesh;
  mesh.positions = positions;
  mesh.indices = indices;
  return mesh;
}

Mesh randomMesh(uint32_t triangles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> at(-1, 1);
  Mesh mesh;
  for (uint32_t i = 0; i < 3 * triangles; ++i) {
    mesh.positions.emplace_back(at(random), at(random), at(random));
    mesh.indices.push_back(i);
  }
  return mesh;
}

const Mesh& ball() {
  static const Scene scene = load("builtin:spheres");
  return scene.meshes.front();
}

TEST(Clusters, AreAllOfAMesh) {
  for (const uint32_t triangles : {1u, 127u, 128u, 129u, 1000u}) {
    const Mesh mesh = randomMesh(triangles);
    const Clusters all = clustersOf(mesh);
    ASSERT_EQ(all.clusters.size(), (triangles + 127) / 128);
    for (size_t i = 0; i < all.clusters.size(); ++i)
      for (const Corners& t : trianglesOf(mesh, all, i))
        for (const vec3& corner : {t.a, t.b, t.c})
          EXPECT_LE(glm::distance(corner, vec3(all.clusters[i].center)), all.clusters[i].radius * (1 + kRounding));
  }
  EXPECT_TRUE(clustersOf({}).clusters.empty());
}

// Every triangle occurs once, with its own corners in their order, whether vertices are shared or not.
TEST(Clusters, HaveEveryTriangleOnce) {
  for (const Mesh& mesh : {randomMesh(1000), ball()}) {
    const Clusters all = clustersOf(mesh);
    ASSERT_EQ(all.triangles.size(), mesh.indices.size() / 3);
    std::vector<bool> seen(all.triangles.size());
    for (size_t i = 0; i < all.triangles.size(); ++i) {
      const shared::ClusterTriangle& triangle = all.triangles[i];
      ASSERT_FALSE(seen[triangle.number]);
      seen[triangle.number] = true;
      const size_t cluster = i / shared::kClusterTriangles;
      ASSERT_EQ(all.clusterOfTriangle[triangle.number], cluster);
      for (uint32_t j = 0; j < 3; ++j)
        ASSERT_EQ(all.vertices[all.clusters[cluster].firstVertex + shared::clusterCorner(triangle, j)],
                  mesh.indices[3 * size_t{triangle.number} + j]);
    }
  }
}

// A file may store its triangles in any order.
TEST(Clusters, AreCompactWhateverTheOrder) {
  Mesh shuffled = ball();
  std::vector<std::array<uint32_t, 3>> triangles(shuffled.indices.size() / 3);
  std::memcpy(triangles.data(), shuffled.indices.data(), shuffled.indices.size() * sizeof(uint32_t));
  std::ranges::shuffle(triangles, std::mt19937(3));
  std::memcpy(shuffled.indices.data(), triangles.data(), shuffled.indices.size() * sizeof(uint32_t));
  double area = 0;
  for (const auto& [a, b, c] : triangles)
    area += glm::length(glm::cross(shuffled.positions[b] - shuffled.positions[a],
                                   shuffled.positions[c] - shuffled.positions[a])) /
            2;
  for (const Mesh& mesh : {ball(), shuffled}) {
    double sum = 0;
    const Clusters all = clustersOf(mesh);
    for (const shared::Cluster& cluster : all.clusters) sum += cluster.radius;
    // The radius for a square of the same area is half its diagonal.
    const auto count = static_cast<double>(all.clusters.size());
    EXPECT_LT(sum / count, 1.5 * std::sqrt(area / count / 2));
  }
}

TEST(Clusters, FaceAwayOnlyWhereAllOfTheirTrianglesDo) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> distance(0, 4);
  const Clusters all = clustersOf(ball());
  size_t away = 0, tested = 0;
  for (int i = 0; i < 200; ++i) {
    const vec3 way = glm::normalize(vec3(normal(random), normal(random), normal(random)));
    const vec3 eye = way * distance(random);
    for (size_t c = 0; c < all.clusters.size(); ++c, ++tested) {
      const shared::Cluster& cluster = all.clusters[c];
      const bool inPerspective =
          shared::clusterFacesAway(glm::normalize(vec3(cluster.apex) - eye), cluster.axis, cluster.cutoff, 0);
      const bool orthographic = shared::clusterFacesAway(-way, cluster.axis, cluster.cutoff, 0);
      away += inPerspective;
      for (const Corners& t : trianglesOf(ball(), all, c)) {
        const vec3 n = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
        EXPECT_TRUE(!inPerspective || glm::dot(n, t.a - eye) >= -kRounding);
        EXPECT_TRUE(!orthographic || glm::dot(n, -way) >= -kRounding);
      }
    }
  }
  EXPECT_GT(away, tested / 5) << "of a ball, half faces away";
}

TEST(Clusters, WithoutAnAreaFaceAllWays) {
  Mesh mesh = meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}}, {0, 1, 2, 0, 1, 3});
  EXPECT_EQ(clustersOf(mesh).clusters.front().cutoff, 1);
  mesh.indices.resize(3);
  EXPECT_LT(clustersOf(mesh).clusters.front().cutoff, 1);
}

}  // namespace
}  // namespace latelight::scene
