// Rays through worlds, from arrays: distances in closed form, the hits of the edited scene, and errors.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "placed.h"
#include "test_device.h"

namespace latelight {
namespace {

using test::placed;
using test::testDevice;
using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The box [-1, 1]^3, in a scene with glTF's axes.
struct BoxScene {
  Scene scene;
  Handle<Instance> box;

  BoxScene() {
    MeshData mesh{.name = "box"};
    for (int corner = 0; corner < 8; ++corner)
      mesh.positions.push_back({corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f});
    mesh.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    box = scene.addInstance(scene.addMesh(mesh), scene.addMaterial({.name = "white"}), placed(0, 0, 0));
  }
};

template <typename T>
WorldArray numbersIn(const std::vector<T>& numbers) {
  using enum WorldArray::Element;
  return {.element = std::is_same_v<T, float>    ? Float32
                     : std::is_same_v<T, double> ? Float64
                                                 : Uint8,
          .host = numbers.data()};
}

// The array's values on the host.
template <typename T>
std::vector<T> valuesIn(const DeviceArray& array) {
  std::vector<T> values(array.shape[0] * array.shape[1] * array.shape[2] * array.shape[3]);
  array.copyToHost(std::as_writable_bytes(std::span(values)));
  return values;
}

// Four rays per world along -Z, from z = 10 at x = 0, 0.5, 1.5 and 30.
template <typename T>
struct ParallelRays {
  std::vector<T> origins, directions;
  explicit ParallelRays(uint32_t worlds) {
    for (uint32_t world = 0; world < worlds; ++world)
      for (const double x : {0.0, 0.5, 1.5, 30.0}) {
        for (const double value : {x, 0.25, 10.0}) origins.push_back(static_cast<T>(value));
        for (const double value : {0.0, 0.0, -2.0}) directions.push_back(static_cast<T>(value));
      }
  }
  WorldRays get() const { return {numbersIn(origins), numbersIn(directions), 4}; }
};

// Worlds: the box moved along Z, doubled, absent, and not finite.
Worlds movedBoxes(const Handle<Instance>& box) {
  Worlds worlds{.count = 5, .instances = {box}};
  worlds.transforms = {placed(0, 0, 0), placed(0, 0, 3.5), placed(0, 0, -2, 2), placed(0, 0, 0),
                       placed(0, std::numeric_limits<double>::quiet_NaN(), 0)};
  worlds.exists = {1, 1, 1, 0, 1};
  return worlds;
}

template <typename T>
void expectClosedForms() {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<T> rays(5);
  auto arrays = renderer.cast(movedBoxes(made.box), rays.get(), {"distance", "normal", "id", "position"});
  ASSERT_EQ(arrays.size(), 4u);
  EXPECT_EQ(arrays["distance"].shape, (std::array<uint64_t, 4>{1, 5, 4, 1}));
  EXPECT_EQ(arrays["normal"].shape, (std::array<uint64_t, 4>{1, 5, 4, 3}));
  EXPECT_EQ(arrays["id"].element, DeviceArray::Element::Uint32);
  const auto distances = valuesIn<float>(arrays["distance"]), normals = valuesIn<float>(arrays["normal"]),
             positions = valuesIn<float>(arrays["position"]);
  const auto ids = valuesIn<uint32_t>(arrays["id"]);
  // The front of the box is at z = 1, 4.5 and 0; only the doubled one reaches x = 1.5.
  const float none = kInfinity, expected[5][4] = {{9, 9, none, none},
                                                  {5.5f, 5.5f, none, none},
                                                  {10, 10, 10, none},
                                                  {none, none, none, none},
                                                  {none, none, none, none}};
  for (size_t ray = 0; ray < 20; ++ray) {
    SCOPED_TRACE(ray);
    const float distance = expected[ray / 4][ray % 4];
    EXPECT_FLOAT_EQ(distances[ray], distance);
    EXPECT_EQ(ids[ray] != 0, distance < kInfinity);
    EXPECT_EQ(normals[3 * ray + 2], distance < kInfinity ? 1 : 0);
    if (distance < kInfinity) {
      EXPECT_NEAR(positions[3 * ray + 2], 10 - distance, 2e-6);
    }
  }
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
}

TEST(WorldCast, DistancesToMovedBoxesFromFloats) {
  expectClosedForms<float>();
}

TEST(WorldCast, DistancesToMovedBoxesFromDoubles) {
  expectClosedForms<double>();
}

// Worlds move the vertices of the box: by 3 m along Z, and to twice its width. The second call swaps them.
TEST(WorldCast, DistancesToMovedVertices) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const Handle<Mesh> mesh = made.scene.instance(made.box).mesh;
  const std::vector<std::array<float, 3>> rest = made.scene.meshData(mesh).positions;
  const ParallelRays<float> rays(3);
  const float width[3] = {1, 1, 2}, up[3] = {0, 3, 0};
  const float none = kInfinity, expected[3][4] = {{9, 9, none, none}, {6, 6, none, none}, {9, 9, 9, none}};
  for (uint32_t turn = 0; turn < 3; ++turn) {
    std::vector<float> vertices;
    for (uint32_t world = 0; world < 3; ++world)
      for (const auto& [x, y, z] : rest) {
        const uint32_t shape = (world + turn) % 3;
        vertices.insert(vertices.end(), {width[shape] * x, width[shape] * y, z + up[shape]});
      }
    Worlds worlds{.count = 3, .meshes = {mesh}};
    worlds.arrays.vertices = {.element = WorldArray::Element::Float32, .rows = 3, .host = vertices.data()};
    auto arrays = renderer.cast(worlds, rays.get(), {"distance"});
    const auto distances = valuesIn<float>(arrays["distance"]);
    for (size_t ray = 0; ray < 12; ++ray) EXPECT_FLOAT_EQ(distances[ray], expected[(ray / 4 + turn) % 3][ray % 4]);
  }
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
}

// Random rays in random worlds hit as those through the edited scene, to the byte; from lists and from arrays.
TEST(WorldCast, HitsAreThoseOfTheEditedScene) {
  constexpr uint32_t kWorlds = 4, kRays = 500;
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, testDevice());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-0.3, 0.3), wide(-2, 2);
  const std::vector<std::string> outputs{"distance", "position", "normal",   "geonormal", "uv",
                                         "id",       "part",     "material", "triangle",  "intensity"};
  Worlds worlds{.count = kWorlds, .instances = scene.instances()};
  const size_t listed = worlds.instances.size();
  for (uint32_t i = 0; i < kWorlds * listed; ++i) {
    Transform transform = scene.instance(worlds.instances[i % listed]).transform;
    for (const int entry : {3, 7, 11}) transform[entry] += offset(random);
    worlds.transforms.push_back(transform);
    worlds.exists.push_back(random() % 5 != 0);
  }
  std::vector<double> origins, directions;
  for (uint32_t i = 0; i < 3 * kWorlds * kRays; ++i)
    origins.push_back(wide(random)), directions.push_back(wide(random));
  WorldRays rays{numbersIn(origins), numbersIn(directions), kRays};
  auto hits = renderer.cast(worlds, rays, outputs);
  Worlds arrays{.count = kWorlds, .instances = worlds.instances};
  std::vector<double> transforms;
  for (const Transform& transform : worlds.transforms)
    transforms.insert(transforms.end(), transform.begin(), transform.end());
  arrays.arrays.transforms = numbersIn(transforms);
  arrays.arrays.exists = numbersIn(worlds.exists);
  const auto again = renderer.cast(arrays, rays, outputs);
  for (const std::string& name : outputs)
    EXPECT_EQ(valuesIn<uint32_t>(hits[name]), valuesIn<uint32_t>(again.at(name))) << name;
  const auto distances = valuesIn<float>(hits["distance"]), normals = valuesIn<float>(hits["normal"]);
  const auto ids = valuesIn<uint32_t>(hits["id"]), triangles = valuesIn<uint32_t>(hits["triangle"]);
  size_t found = 0;
  for (uint32_t world = 0; world < kWorlds; ++world) {
    Scene edited("builtin:boxes");
    const std::vector<Handle<Instance>> there = edited.instances();
    for (size_t i = 0; i < listed; ++i) edited.setTransform(there[i], worlds.transforms[world * listed + i]);
    for (size_t i = 0; i < listed; ++i)
      if (!worlds.exists[world * listed + i]) edited.removeInstance(there[i]);
    Renderer alone(edited, testDevice());
    const auto vectors = [&](const std::vector<double>& numbers) {
      return std::span(reinterpret_cast<const std::array<double, 3>*>(numbers.data()) + world * kRays, kRays);
    };
    const CastHits expected = alone.cast(vectors(origins), vectors(directions));
    const size_t first = world * kRays;
    EXPECT_EQ(std::memcmp(distances.data() + first, expected.distance.data(), kRays * sizeof(float)), 0) << world;
    EXPECT_EQ(std::memcmp(normals.data() + 3 * first, expected.normal.data(), kRays * 3 * sizeof(float)), 0) << world;
    EXPECT_EQ(std::memcmp(ids.data() + first, expected.id.data(), kRays * sizeof(uint32_t)), 0) << world;
    EXPECT_EQ(std::memcmp(triangles.data() + first, expected.triangle.data(), kRays * sizeof(uint32_t)), 0) << world;
    for (const float distance : expected.distance) found += distance < kInfinity;
  }
  EXPECT_GT(found, kRays / 2);
}

// An array of an earlier call receives the hits of a later one.
TEST(WorldCast, StoresHitsInGivenArrays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<float> rays(5);
  Worlds worlds = movedBoxes(made.box);
  const auto first = renderer.cast(worlds, rays.get());
  worlds.transforms[0] = placed(0, 0, 1);
  const auto second = renderer.cast(worlds, rays.get(), {"distance"}, {}, first);
  EXPECT_FLOAT_EQ(valuesIn<float>(first.at("distance"))[0], 8);
  EXPECT_FLOAT_EQ(valuesIn<float>(second.at("distance"))[0], 8);
  EXPECT_FLOAT_EQ(valuesIn<float>(second.at("distance"))[4], 5.5f);
}

TEST(WorldCast, RejectsWrongArrays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<float> floats(5);
  const ParallelRays<double> doubles(5);
  const auto refused = [&](const std::function<void(WorldRays&)>& change, const std::string& output = "distance") {
    WorldRays rays = floats.get();
    change(rays);
    try {
      renderer.cast(movedBoxes(made.box), rays, {output});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      return std::string(error.what());
    }
    return std::string("nothing was refused");
  };
  EXPECT_THAT(refused([](WorldRays& r) { r.origins = {}; }), HasSubstr("WorldRays::origins must be given"));
  EXPECT_THAT(refused([&](WorldRays& r) { r.directions = doubles.get().directions; }), HasSubstr("the same type"));
  EXPECT_THAT(refused([](WorldRays& r) { r.origins.element = WorldArray::Element::Int32; }), HasSubstr("Float32 or"));
  EXPECT_THAT(refused([](WorldRays& r) { r.maxDistance = -1; }), HasSubstr("at least 0, not -1"));
  EXPECT_THAT(refused([](WorldRays&) {}, "color"), HasSubstr("rays have no output \"color\""));
  EXPECT_THAT(refused([](WorldRays& r) { r.count = 1u << 30; }), HasSubstr("too many for one call"));
}

}  // namespace
}  // namespace latelight
