// The BVHs over the instances of worlds, which the device builds: their structure for any number of instances, boxes
// that contain all vertices, and the same bytes each time.
#include <fmt/core.h>

#include <bit>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "rays/bvh_checks.h"
#include "render/rays/scene_bvh.h"
#include "render/support.h"
#include "scene/scene_builder.h"

namespace latelight::render::test {
namespace {

using glm::dmat4;
using glm::dvec3;

constexpr uint32_t kWorlds = 5;

scene::Mesh tetrahedron(float size) {
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
  mesh.attributes.resize(4, {glm::vec3(0, 0, 1), glm::vec4(1, 0, 0, 1), glm::vec2(0)});
  mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  scene::findBounds(mesh);
  return mesh;
}

// Instances of three meshes, of which one has no triangles, far from the origin of the world.
scene::SceneBuilder sceneOf(uint32_t instances) {
  scene::SceneBuilder builder("instances");
  builder.scene.meshes = {tetrahedron(1), tetrahedron(0.01f), scene::Mesh{}};
  builder.scene.materials = {scene::plainMaterial("m", glm::vec3(0.5f), 0, 1)};
  for (uint32_t i = 0; i < instances; ++i) {
    builder.addInstance("instance", builder.kRoot, i % 7 == 6 ? 2 : i % 2, 0);
    builder.scene.instances[i].toWorld = glm::translate(dmat4(1), dvec3(1000, -2000, 10.0 * i));
  }
  return builder;
}

// Random transforms, some of which flatten or mirror; each fifth instance is absent, and the last world is empty.
WorldStates randomStates(const scene::Scene& scene) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> offset(-20, 20), size(0.1, 3);
  WorldStates worlds{.count = kWorlds, .empty = std::vector<uint8_t>(kWorlds)};
  worlds.empty.back() = 1;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) worlds.instances.push_back(i);
  for (uint32_t i = 0; i < kWorlds * scene.instances.size(); ++i) {
    const double x = offset(random), y = offset(random), z = offset(random);
    dmat4 placed = glm::translate(dmat4(1), dvec3(1000 + x, -2000 + y, z));
    placed = glm::rotate(placed, offset(random), glm::normalize(dvec3(x, y, z)));
    const double sign = random() % 3 == 0 ? -1 : 1, depth = random() % 5 == 0 ? 0 : 1;
    worlds.transforms.push_back(glm::scale(placed, dvec3(sign * size(random), size(random), depth * size(random))));
    worlds.exists.push_back(i % 5 != 3);
  }
  return worlds;
}

// The worlds of a scene on the device, with their BVHs.
class BuiltWorlds {
 public:
  BuiltWorlds(vk::Device& device, const scene::Scene& scene, const WorldStates& worlds)
      : scene_(scene),
        worlds_(worlds),
        gpuScene_(device, scene),
        executor_(device),
        bvh_(device, executor_, scene, gpuScene_) {
    gpuScene_.update({});
    gpuScene_.setWorlds(worlds, {}, {});
    bvh_.update();
    graph::Graph graph(executor_);
    gpuScene_.addChanges(graph);
    bvh_.addChanges(graph);
    executor_.submit(graph, graph.compile()).wait();
    gpuScene_.changesSubmitted();
    bvh_.changesSubmitted();
  }

  Bvh read(uint32_t world) const { return bvh_.readWorld(world); }

  bool isPresent(uint32_t world, uint32_t instance) const {
    const scene::Instance& of = scene_.instances[instance];
    return !worlds_.empty[world] && worlds_.exists[world * scene_.instances.size() + instance] != 0 &&
           !scene_.meshes[of.mesh].indices.empty();
  }
  // The box of an instance's vertices in the device's world space, in double precision.
  Box boxOf(uint32_t world, uint32_t instance) const {
    Box box;
    const dmat4& toWorld = worlds_.transforms[world * scene_.instances.size() + instance];
    for (const glm::vec3& position : scene_.meshes[scene_.instances[instance].mesh].positions)
      box.add(glm::vec3(dvec3(toWorld * glm::dvec4(position, 1)) - gpuScene_.origin()));
    return box;
  }

 private:
  const scene::Scene& scene_;
  const WorldStates& worlds_;
  GpuScene gpuScene_;
  graph::Executor executor_;
  SceneBvh bvh_;
};

class WorldBvhTest : public RenderTest {
 protected:
  // The hierarchy of a world of unit boxes at places on the x axis.
  static Bvh boxesAt(const std::vector<double>& places) {
    scene::SceneBuilder builder("line");
    builder.scene.meshes = {tetrahedron(1)};
    builder.scene.materials = {scene::plainMaterial("m", glm::vec3(0.5f), 0, 1)};
    WorldStates states{.count = 1, .exists = std::vector<uint8_t>(places.size(), 1), .empty = {0}};
    for (const double x : places) {
      builder.addInstance("box", builder.kRoot, 0, 0);
      states.instances.push_back(static_cast<uint32_t>(states.instances.size()));
      states.transforms.push_back(glm::translate(dmat4(1), dvec3(x, 0, 0)));
    }
    return BuiltWorlds(device(), builder.scene, states).read(0);
  }
};

TEST_F(WorldBvhTest, HoldsTheInstancesOfTheWorldInTheirBoxes) {
  for (const uint32_t instances : {1u, 2u, 3u, 4u, 5u, 8u, 30u, 63u, 64u, 65u, 100u, 257u, 1000u}) {
    const scene::SceneBuilder builder = sceneOf(instances);
    const WorldStates states = randomStates(builder.scene);
    const BuiltWorlds worlds(device(), builder.scene, states), again(device(), builder.scene, states);
    for (uint32_t world = 0; world < kWorlds; ++world) {
      SCOPED_TRACE(fmt::format("{} instances, world {}", instances, world));
      Bvh bvh = worlds.read(world);
      const Bvh other = again.read(world);
      ASSERT_EQ(bvh.items, other.items);
      ASSERT_EQ(bvh.nodes.size(), other.nodes.size());
      if (!bvh.nodes.empty()) {
        EXPECT_EQ(std::memcmp(bvh.nodes.data(), other.nodes.data(), bvh.nodes.size() * sizeof(bvh.nodes[0])), 0);
      }
      std::vector<uint32_t> present;
      std::vector<Box> boxes;
      for (uint32_t i = 0; i < instances; ++i)
        if (worlds.isPresent(world, i)) present.push_back(i), boxes.push_back(worlds.boxOf(world, i));
      if (present.empty()) {
        EXPECT_TRUE(bvh.nodes.empty());
        continue;
      }
      for (uint32_t& item : bvh.items) {
        const auto found = std::ranges::find(present, item);
        ASSERT_NE(found, present.end()) << item;
        item = static_cast<uint32_t>(found - present.begin());
      }
      const auto count = static_cast<uint32_t>(present.size());
      const uint32_t pairs =
          static_cast<uint32_t>(std::bit_width(count - 1));  // rounds that merge all clusters in pairs
      const uint32_t most = count <= 64 ? std::min(count - 1, 16 + pairs) : pairs;
      expectSound(bvh, boxes, 1, std::max(1u, most));
    }
  }
}

// Two groups of boxes that Morton codes interleave have no common node except the root: their common box is large.
TEST_F(WorldBvhTest, MergesNearBoxesFirst) {
  std::vector<double> places;
  for (uint32_t i = 0; i < 14; ++i)
    places.push_back(i < 3 ? 1.5 * i : 100 + 1.5 * i);  // three boxes, and eleven far away
  const Bvh bvh = boxesAt(places);
  ASSERT_EQ(bvh.nodes.size(), 13u);
  const float a = bvh.nodes[0].highA.x - bvh.nodes[0].lowA.x, b = bvh.nodes[0].highB.x - bvh.nodes[0].lowB.x;
  EXPECT_NEAR(std::min(a, b), 4, 1e-2f);   // 0 to 3 + 1
  EXPECT_NEAR(std::max(a, b), 16, 1e-2f);  // 4.5 to 19.5 + 1
}

// Boxes at known places: 16 unit boxes on a line. In Morton order, neighbors share parents, so the areas of all boxes
// are known: two boxes at a distance of 3 span 4 x 1 x 1, and so on.
TEST_F(WorldBvhTest, BoxesAreTightAndNeighborsShareParents) {
  std::vector<double> places;
  for (uint32_t i = 0; i < 16; ++i) places.push_back(3.0 * ((5 * i) % 16));  // in another order
  const Bvh bvh = boxesAt(places);
  ASSERT_EQ(bvh.nodes.size(), 15u);
  const float lengths[] = {22, 10, 4, 1};  // of the children of each level
  for (uint32_t i = 0; i < 15; ++i) {
    const float expected = lengths[std::bit_width(i + 1) - 1];
    EXPECT_NEAR(bvh.nodes[i].highA.x - bvh.nodes[i].lowA.x, expected, 1e-3f) << i;
    EXPECT_NEAR(bvh.nodes[i].highB.x - bvh.nodes[i].lowB.x, expected, 1e-3f) << i;
  }
}

}  // namespace
}  // namespace latelight::render::test
