#include "scene/vertex_bounds.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <random>

namespace latelight::scene {
namespace {

Mesh meshOf(std::vector<vec3> positions) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  findBounds(mesh);
  return mesh;
}

void expectBounds(const Bounds& bounds, dvec3 low, dvec3 high, double tolerance) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bounds.min[axis], low[axis], tolerance) << axis;
    EXPECT_NEAR(bounds.max[axis], high[axis], tolerance) << axis;
  }
}

// The octahedron's corners on the axes are turned by 45 degrees, so that they reach 1 / sqrt(2). Its box reaches
// sqrt(2).
TEST(VertexBounds, RotatedInstancesAreNoLargerThanTheirVertices) {
  Scene scene;
  scene.meshes.push_back(
      meshOf({vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1)}));
  const dmat4 moved = glm::translate(dmat4(1), dvec3(10, 20, 30));
  scene.instances.push_back({.toWorld = glm::rotate(moved, std::numbers::pi / 4, dvec3(0, 0, 1))});
  const double half = 1 / std::numbers::sqrt2;
  expectBounds(vertexBounds(scene), {10 - half, 20 - half, 29}, {10 + half, 20 + half, 31}, 1e-12);
  expectBounds(worldBounds(scene), {10 - 2 * half, 20 - 2 * half, 29}, {10 + 2 * half, 20 + 2 * half, 31}, 1e-12);
}

TEST(VertexBounds, AreEmptyWithoutVisibleVertices) {
  Scene scene;
  EXPECT_TRUE(vertexBounds(scene).empty());
  scene.meshes.push_back(meshOf({vec3(1, 2, 3)}));
  scene.meshes.emplace_back();
  scene.instances = {{.mesh = 1}, {.mesh = 0, .removed = true}, {.mesh = 0, .hidden = true}};
  EXPECT_TRUE(vertexBounds(scene).empty());
  scene.instances.push_back({.mesh = 0});
  expectBounds(vertexBounds(scene), {1, 2, 3}, {1, 2, 3}, 0);
}

// Instances of all kinds of transforms, whose extremes are those of all transformed vertices.
TEST(VertexBounds, AreThoseOfAllVertices) {
  std::minstd_rand random(1);
  const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  Scene scene;
  for (const size_t count : {1, 3, 100, 200'000}) {
    std::vector<vec3> positions(count);
    for (vec3& p : positions) p = vec3(number(), number(), number());
    scene.meshes.push_back(meshOf(std::move(positions)));
  }
  dvec3 low(1e9), high(-1e9);
  for (uint32_t i = 0; i < 1000; ++i) {
    Instance instance{.mesh = i == 500 ? 3 : i % 3, .hidden = i % 7 == 0};
    instance.toWorld[3] = glm::dvec4(number(), number(), number(), 1) * glm::dvec4(dvec3(20), 1);
    for (int axis = 0; axis < 3; ++axis)
      if (i % 4 == 0)
        instance.toWorld[axis] = glm::dvec4(axis == 1, axis == 2, axis == 0, 0) * number();
      else if (i % 4 != 1)
        instance.toWorld[axis] = glm::dvec4(number(), number(), number(), 0);
    scene.instances.push_back(instance);
    if (instance.hidden) continue;
    for (const vec3& p : scene.meshes[instance.mesh].positions) {
      const dvec3 world = instance.toWorld * glm::dvec4(p, 1.0);
      low = glm::min(low, world), high = glm::max(high, world);
    }
  }
  expectBounds(vertexBounds(scene), low, high, 1e-12);
}

}  // namespace
}  // namespace latelight::scene
