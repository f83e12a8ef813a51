// Clusters against what they stand for: every triangle of theirs is in their sphere, and shows its back where they say
// so.
#include "scene/clusters.h"

#include <gtest/gtest.h>

#include <random>

#include "scene/builtin.h"

namespace latelight::scene {
namespace {

constexpr float kRounding = 1e-5f;

struct Corners {
  vec3 a, b, c;
};
std::vector<Corners> trianglesOf(const Mesh& mesh, size_t cluster) {
  const size_t first = 3 * shared::kClusterTriangles * cluster;
  std::vector<Corners> triangles;
  for (size_t i = first; i < std::min(mesh.indices.size(), first + 3 * shared::kClusterTriangles); i += 3)
    triangles.push_back(
        {mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[i + 1]], mesh.positions[mesh.indices[i + 2]]});
  return triangles;
}

// Positions and triangles alone.
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
    const std::vector<shared::Cluster> clusters = clustersOf(mesh);
    ASSERT_EQ(clusters.size(), (triangles + 127) / 128);
    for (size_t i = 0; i < clusters.size(); ++i)
      for (const Corners& t : trianglesOf(mesh, i))
        for (const vec3& corner : {t.a, t.b, t.c})
          EXPECT_LE(glm::distance(corner, vec3(clusters[i].centre)), clusters[i].radius * (1 + kRounding));
  }
  EXPECT_TRUE(clustersOf({}).empty());
}

TEST(Clusters, FaceAwayOnlyWhereAllOfTheirTrianglesDo) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> distance(0, 4);
  const std::vector<shared::Cluster> clusters = clustersOf(ball());
  size_t away = 0, all = 0;
  for (int i = 0; i < 200; ++i) {
    const vec3 way = glm::normalize(vec3(normal(random), normal(random), normal(random)));
    const vec3 eye = way * distance(random);
    for (size_t c = 0; c < clusters.size(); ++c, ++all) {
      const shared::Cluster& cluster = clusters[c];
      const bool inPerspective =
          shared::clusterFacesAway(glm::normalize(vec3(cluster.apex) - eye), cluster.axis, cluster.cutoff, 0);
      const bool orthographic = shared::clusterFacesAway(-way, cluster.axis, cluster.cutoff, 0);
      away += inPerspective;
      for (const Corners& t : trianglesOf(ball(), c)) {
        const vec3 n = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
        EXPECT_TRUE(!inPerspective || glm::dot(n, t.a - eye) >= -kRounding);
        EXPECT_TRUE(!orthographic || glm::dot(n, -way) >= -kRounding);
      }
    }
  }
  EXPECT_GT(away, all / 5) << "of a ball, half faces away";
}

TEST(Clusters, WithoutAnAreaFaceAllWays) {
  Mesh mesh = meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}}, {0, 1, 2, 0, 1, 3});
  EXPECT_EQ(clustersOf(mesh).front().cutoff, 1);
  mesh.indices.resize(3);
  EXPECT_LT(clustersOf(mesh).front().cutoff, 1);
}

}  // namespace
}  // namespace latelight::scene
