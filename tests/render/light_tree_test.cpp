// The light tree on the host: order, bounding boxes, and that every light's range lies inside the boxes of its
// ancestors.
#include "render/gpu_scene/light_tree.h"

#include <gtest/gtest.h>

#include <fmt/core.h>
#include <algorithm>
#include <random>

#include "shared/light.h"

namespace latelight::render {
namespace {

using shared::kLightTreeWidth;
using shared::Light;
using shared::LightBox;
using shared::vec3;

class Lights {  // random lights of every type, size and position
 public:
  explicit Lights(uint32_t seed) : engine_(seed) {}
  float between(float low, float high) { return std::uniform_real_distribution(low, high)(engine_); }
  vec3 direction() {
    for (;;) {
      const vec3 d(between(-1, 1), between(-1, 1), between(-1, 1));
      if (glm::dot(d, d) > 0.01f && glm::dot(d, d) < 1) return glm::normalize(d);
    }
  }
  Light make(uint32_t type) {
    Light light{};
    light.type = type;
    light.position = vec3(between(-50, 50), between(-50, 50), between(-5, 5));
    light.direction = direction();
    light.intensity = vec3(between(0.1f, 10));
    light.radius = std::exp2(between(-6, 6));
    const float outer = between(0.01f, 1.57f);
    if (type == shared::kLightSpot) shared::spotCone(between(0, 1) * outer, outer, light.spotScale, light.spotOffset);
    if (type == shared::kLightDirectional) light.radius = std::numeric_limits<float>::infinity();
    return light;
  }
  std::vector<Light> make(size_t local, size_t directional) {
    std::vector<Light> lights;
    for (size_t i = 0; i < local; ++i) lights.push_back(make(i % 3 == 2 ? shared::kLightSpot : shared::kLightPoint));
    for (size_t i = 0; i < directional; ++i) lights.push_back(make(shared::kLightDirectional));
    std::shuffle(lights.begin(), lights.end(), engine_);
    return lights;
  }

 private:
  std::mt19937 engine_;
};

bool holds(const LightBox& outer, const LightBox& inner) {
  return glm::all(glm::lessThanEqual(outer.low, inner.low)) && glm::all(glm::greaterThanEqual(outer.high, inner.high));
}

std::vector<std::vector<float>> sorted(const std::vector<Light>& lights) {
  std::vector<std::vector<float>> all;
  for (const Light& l : lights)
    all.push_back({l.position.x, l.position.y, l.position.z, l.radius, l.direction.x, l.direction.y, l.direction.z,
                   static_cast<float>(l.type), l.intensity.x, l.spotScale, l.spotOffset});
  std::sort(all.begin(), all.end());
  return all;
}

// Walks the heap as the shaders do, and calls leaf(first light, box) in order.
template <typename Leaf>
void walk(const LightTree& tree, uint32_t group, const LightBox& around, const Leaf& leaf) {
  for (uint32_t i = 0; i < kLightTreeWidth; ++i) {
    const uint32_t node = group * kLightTreeWidth + i;
    ASSERT_LT(node, tree.nodes.size());
    const LightBox& box = tree.nodes[node];
    if (box.low.x > box.high.x) continue;
    EXPECT_TRUE(holds(around, box)) << "node " << node;
    if (node >= tree.firstLeaf)
      leaf(tree.directionalLights + (node - tree.firstLeaf) * kLightTreeWidth, box);
    else
      walk(tree, node + 1, box, leaf);
  }
}

TEST(LightTree, HoldsEveryLightOnceAndInOrder) {
  for (size_t local : {0, 1, 31, 32, 33, 1000, 1024, 1025, 32768, 32769, 40000})
    for (size_t directional : {0, 3}) {
      SCOPED_TRACE(fmt::format("{} local lights, {} directional", local, directional));
      const std::vector<Light> lights = Lights(7).make(local, directional);
      const LightTree tree = buildLightTree(lights);
      EXPECT_EQ(sorted(tree.lights), sorted(lights));
      EXPECT_EQ(tree.directionalLights, directional);
      for (size_t i = 0; i < tree.lights.size(); ++i)
        EXPECT_EQ(tree.lights[i].type == shared::kLightDirectional, i < directional) << i;
      size_t next = directional;
      const LightBox everywhere{vec3(-1e30f), vec3(1e30f)};
      walk(tree, 0, everywhere, [&](uint32_t first, const LightBox& box) {
        EXPECT_EQ(first, next);
        for (; next < std::min<size_t>(first + kLightTreeWidth, tree.lights.size()); ++next)
          EXPECT_TRUE(holds(box, lightBox(tree.lights[next])));
      });
      EXPECT_EQ(next, tree.lights.size());
    }
}

TEST(LightTree, NeighborsAreGrouped) {
  std::vector<Light> lights = Lights(8).make(20000, 0);
  for (Light& light : lights) light.radius = 0.5f;
  const LightTree tree = buildLightTree(lights);
  double sizes = 0, leaves = 0;
  walk(tree, 0, {vec3(-1e30f), vec3(1e30f)}, [&](uint32_t, const LightBox& box) {
    sizes += glm::length(box.high - box.low);
    ++leaves;
  });
  // 32 of 20000 lights in 100 m x 100 m x 10 m fill a cube with a diagonal of 9.4 m, or 10.9 m with their radius. In
  // random order, their box would have a diagonal of 140 m.
  EXPECT_LT(sizes / leaves, 25);
}

TEST(LightTree, NoLightReachesOutOfItsBox) {
  Lights random(9);
  size_t lit = 0;
  for (int i = 0; i < 3000; ++i) {
    const Light light = random.make(i % 2 ? shared::kLightSpot : shared::kLightPoint);
    const LightBox box = lightBox(light);
    for (int j = 0; j < 300; ++j) {
      // Points near the light's radius, in random directions and in directions near its axis.
      vec3 d = random.direction();
      if (j % 3 == 0) d = glm::normalize(light.direction + 0.05f * d);
      const vec3 position = light.position + d * light.radius * random.between(0.9f, 1.0f);
      if (shared::maxChannel(shared::irradianceOf(shared::sampleLight(light, position))) <= 0) continue;
      ++lit;
      ASSERT_TRUE(holds(box, {position, position})) << i;
    }
  }
  EXPECT_GT(lit, 200000u);
}

// Lights without a range, lit at distances from a millimeter to a thousand kilometers.
TEST(LightTree, NoUnboundedLightReachesOutOfItsBox) {
  Lights random(12);
  size_t lit = 0, bounded = 0;
  for (int i = 0; i < 1000; ++i) {
    Light light = random.make(i % 4 ? shared::kLightSpot : shared::kLightPoint);
    light.radius = std::numeric_limits<float>::infinity();
    const LightBox box = lightBox(light);
    for (int axis = 0; axis < 3; ++axis) bounded += std::isfinite(box.low[axis]) + std::isfinite(box.high[axis]);
    for (int j = 0; j < 300; ++j) {
      const vec3 d = glm::normalize(j % 2 ? random.direction() : light.direction + 0.5f * random.direction());
      const vec3 position = light.position + d * std::pow(10.0f, random.between(-3, 6));
      if (shared::maxChannel(shared::irradianceOf(shared::sampleLight(light, position))) <= 0) continue;
      ++lit;
      ASSERT_TRUE(holds(box, {position, position})) << i;
    }
  }
  EXPECT_GT(lit, 100000u);
  EXPECT_GT(bounded, 500u);  // the boxes of spot lights end behind them
}

TEST(LightTree, ASpotsBoxIsSmallerThanItsSphere) {
  Light spot = Lights(10).make(shared::kLightSpot);
  spot.direction = {0, 0, 1};
  shared::spotCone(0.1f, 0.5f, spot.spotScale, spot.spotOffset);
  const vec3 size = lightBox(spot).high - lightBox(spot).low;
  EXPECT_NEAR(size.z, spot.radius, 0.002f * spot.radius);
  EXPECT_NEAR(size.x, 2 * std::sin(0.5f) * spot.radius, 0.002f * spot.radius);
}

TEST(LightTree, AMillionLightsTakeLittleMemory) {
  const std::vector<Light> lights = Lights(11).make(1'000'000, 1);
  const LightTree tree = buildLightTree(lights);
  EXPECT_LT(tree.nodes.size() * sizeof(LightBox), 2u << 20);
}

}  // namespace
}  // namespace latelight::render
