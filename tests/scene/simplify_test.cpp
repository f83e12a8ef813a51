#include "scene/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scene/builtin/builtin.h"
#include "scene/load/load.h"

namespace latelight::scene {
namespace {

TEST(Simplify, LeavesAboutAsManyTrianglesAsAsked) {
  Scene scene = load("builtin:hall,triangles=50k,lights=1");
  const Bounds before = worldBounds(scene);
  ASSERT_NEAR(static_cast<double>(scene.triangleCount()), 50'000, 1'000);
  simplify(scene, 10'000);
  EXPECT_LE(scene.triangleCount(), 11'500u);
  EXPECT_GE(scene.triangleCount(), 8'500u);
  for (const Mesh& mesh : scene.meshes) {
    EXPECT_FALSE(mesh.indices.empty()) << mesh.name;
    EXPECT_EQ(mesh.indices.size() % 3, 0u) << mesh.name;
    EXPECT_LT(*std::max_element(mesh.indices.begin(), mesh.indices.end()), mesh.positions.size()) << mesh.name;
  }
  EXPECT_EQ(worldBounds(scene).min, before.min);  // vertices are unchanged
}

TEST(Simplify, LeavesASceneThatIsCoarseEnough) {
  Scene scene = load("builtin:boxes");
  const uint64_t triangles = scene.triangleCount();
  simplify(scene, 1'000'000);
  EXPECT_EQ(scene.triangleCount(), triangles);
}

}  // namespace
}  // namespace latelight::scene
