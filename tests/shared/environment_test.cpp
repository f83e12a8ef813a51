#include "shared/environment.h"

#include <gtest/gtest.h>

#include "shared/random.h"

namespace latelight::shared {
namespace {

// glTF has Y up and looks along -Z; the world has Z up, and Y points away from the viewer.
vec3 worldFromGltf(float x, float y, float z) {
  return vec3(x, -z, y);
}

vec2 lookUp(vec3 world, float degrees) {
  const float radians = degrees * kPi / 180.0f;
  return equirectangular(rotateToEnvironment(world, std::cos(radians), std::sin(radians)));
}

void expectAt(vec2 uv, float u, float v) {
  EXPECT_NEAR(uv.x, u, 1e-6f);
  EXPECT_NEAR(uv.y, v, 1e-6f);
}

TEST(Environment, CenterColumnIsAtPlusXOfTheFilesFrame) {
  expectAt(lookUp(worldFromGltf(1, 0, 0), 0.0f), 0.5f, 0.5f);
  expectAt(lookUp(worldFromGltf(0, 0, 1), 0.0f), 0.75f, 0.5f);
  expectAt(lookUp(worldFromGltf(0, 0, -1), 0.0f), 0.25f, 0.5f);
}

TEST(Environment, RotationBy90PutsTheCenterColumnAtPlusZOfTheFilesFrame) {
  expectAt(lookUp(worldFromGltf(0, 0, 1), 90.0f), 0.5f, 0.5f);
  expectAt(lookUp(worldFromGltf(-1, 0, 0), 180.0f), 0.5f, 0.5f);
  expectAt(lookUp(worldFromGltf(0, 0, -1), 270.0f), 0.5f, 0.5f);
}

TEST(Environment, TopRowIsTheZenithUnderEveryRotation) {
  for (const float degrees : {0.0f, 37.0f, 90.0f, 215.0f}) {
    EXPECT_NEAR(lookUp(worldFromGltf(0, 1, 0), degrees).y, 0.0f, 1e-6f);
    EXPECT_NEAR(lookUp(worldFromGltf(0, -1, 0), degrees).y, 1.0f, 1e-6f);
  }
  EXPECT_TRUE(std::isfinite(equirectangular(vec3(0.0f, 0.0f, 1.0000001f)).y));
}

TEST(Environment, RotationKeepsLengthsAndTheZenith) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const vec3 d = random.direction();
    const float angle = random.uniform(0.0f, 6.28f);
    const vec3 r = rotateToEnvironment(d, std::cos(angle), std::sin(angle));
    EXPECT_NEAR(length(r), 1.0f, 1e-6f);
    EXPECT_EQ(r.z, d.z);
  }
}

// The map's creases, its axes and edges, pass through texel centers: at .5, (size - 1) / 2 and size - 1.5 texels.
TEST(Environment, OctahedralCreasesAreTexelCenters) {
  for (const float size : {4.0f, 18.0f, 258.0f}) {
    const vec2 corner = octahedralTexture(vec2(-1.0f, 1.0f), size) * size;
    EXPECT_NEAR(corner.x, 0.5f, 1e-4f);
    EXPECT_NEAR(corner.y, size - 1.5f, 1e-4f);
    EXPECT_NEAR(octahedralTexture(vec2(0.0f, 0.0f), size).x * size, 0.5f * (size - 1.0f), 1e-4f);
  }
}

TEST(Environment, OctahedralMapKeepsEveryDirection) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const vec3 d = random.direction();
    EXPECT_LE(length(directionFromOctahedral(octahedralFromDirection(d)) - d), 4e-7f);
  }
}

// The square's border folds onto itself: both halves of each edge coincide.
TEST(Environment, OctahedralEdgesFold) {
  for (float t = 0.0f; t <= 1.0f; t += 1.0f / 64.0f) {
    EXPECT_LE(length(directionFromOctahedral(vec2(1.0f, t)) - directionFromOctahedral(vec2(1.0f, -t))), 1e-6f);
    EXPECT_LE(length(directionFromOctahedral(vec2(t, -1.0f)) - directionFromOctahedral(vec2(-t, -1.0f))), 1e-6f);
  }
  EXPECT_EQ(directionFromOctahedral(vec2(-1.0f, -1.0f)), vec3(0.0f, 0.0f, -1.0f));
}

}  // namespace
}  // namespace latelight::shared
