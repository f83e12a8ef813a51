// Rays through worlds, from arrays: distances in closed form, the hits of the edited scene, and errors.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <random>

#include "placed.h"
#include "test_device.h"
#include "worlds/rejection.h"

namespace latelight {
namespace {

using test::placed;
using test::rejectionOf;
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

// The rays begin 1e9 m above the boxes, in a direction that no floats represent. They are aimed at the same points as
// those of movedBoxes(), in the plane z = 0.
TEST(WorldCast, HitsFromFarAway) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  constexpr double kFar = 1e9, kSlope = 0.1, kAlong = 0.99503719020998915;  // 1 / sqrt(1 + kSlope^2)
  std::vector<double> origins, directions;
  for (uint32_t world = 0; world < 5; ++world)
    for (const double x : {0.0, 0.5, 1.5, 30.0}) {
      for (const double value : {x, 0.25 - kSlope * kAlong * kFar, kAlong * kFar}) origins.push_back(value);
      for (const double value : {0.0, kSlope * kAlong, -kAlong}) directions.push_back(value);
    }
  auto arrays = renderer.cast(movedBoxes(made.box), {numbersIn(origins), numbersIn(directions), 4}, {"position"});
  const auto positions = valuesIn<float>(arrays["position"]);
  const float front[5][4] = {{1, 1, 0, 0}, {4.5f, 4.5f, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
  const bool hits[5][4] = {{true, true, false, false}, {true, true, false, false}, {true, true, true, false}, {}, {}};
  for (size_t ray = 0; ray < 20; ++ray) {
    SCOPED_TRACE(ray);
    const float z = front[ray / 4][ray % 4], x = static_cast<float>(origins[3 * ray]);
    const float y = 0.25f - static_cast<float>(kSlope) * z;
    EXPECT_NEAR(positions[3 * ray], hits[ray / 4][ray % 4] ? x : 0, 1e-6);
    EXPECT_NEAR(positions[3 * ray + 1], hits[ray / 4][ray % 4] ? y : 0, 1e-6);
    EXPECT_NEAR(positions[3 * ray + 2], z, 1e-6);
  }
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

// Rays in one world along -Z at the box, which each call moves to another height: closed forms whatever the order.
struct RaysAtHeights {
  static constexpr uint32_t kRays = 1000;
  std::vector<float> origins, directions;
  std::vector<double> transforms;
  Handle<Instance> box;

  explicit RaysAtHeights(const Handle<Instance>& box) : box(box) {
    for (uint32_t i = 0; i < 2 * kRays; ++i)
      origins.insert(origins.end(), {0.5f, 0.25f, 10}), directions.insert(directions.end(), {0, 0, -1});
  }
  // Two worlds, of which the second is 1 m higher. Earlier arrays are overwritten.
  Worlds at(double height) {
    transforms.clear();
    for (const Transform& transform : {placed(0, 0, height), placed(0, 0, height + 1)})
      transforms.insert(transforms.end(), transform.begin(), transform.end());
    Worlds worlds{.count = 2, .instances = {box}};
    worlds.arrays.transforms = numbersIn(transforms);
    return worlds;
  }
  WorldRays get() const { return {numbersIn(origins), numbersIn(directions), kRays}; }
};

void expectHeight(CastTicket& ticket, float height) {
  const auto distances = valuesIn<float>(ticket.takeArrays().at("distance"));
  ASSERT_EQ(distances.size(), 2 * RaysAtHeights::kRays);
  for (size_t i = 0; i < distances.size(); ++i)
    ASSERT_FLOAT_EQ(distances[i], 9 - height - static_cast<float>(i / RaysAtHeights::kRays)) << i;
}

// The arrays of a call are copied. Tickets are taken in any order, one is dropped, and an edit of the scene and
// pictures come in between.
TEST(WorldCast, KeepsSeveralCallsInFlight) {
  BoxScene made;
  Renderer renderer(made.scene, testDevice());
  RaysAtHeights rays(made.box);
  std::vector<CastTicket> tickets;
  for (const double height : {0.0, 2.0, -3.0, 1.5}) tickets.push_back(renderer.submitCast(rays.at(height), rays.get()));
  tickets.erase(tickets.begin() + 1);
  Options options;
  options.width = options.height = 16;
  Ticket picture = renderer.submit({made.scene.lookAt({0, 0, 10}, {0, 0, 0})}, options);
  const Handle<Instance> above = made.scene.addInstance(made.scene.instance(made.box).mesh,
                                                        made.scene.instance(made.box).material, placed(0, 0, 5));
  tickets.push_back(renderer.submitCast(rays.at(0.25), rays.get()));
  made.scene.removeInstance(above);
  expectHeight(tickets[2], 1.5f);
  EXPECT_TRUE(tickets[2].done());
  expectHeight(tickets[0], 0);
  EXPECT_EQ(picture.take().size(), 1u);
  // The box above, whose top is at z = 6, was in the scene of this call, and not in those of the others.
  for (const float distance : valuesIn<float>(tickets[3].takeArrays().at("distance"))) ASSERT_FLOAT_EQ(distance, 4);
  expectHeight(tickets[1], -3);
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
}

// Two calls in flight of which one receives the arrays of the call before.
TEST(WorldCast, TicketsStoreHitsInGivenArrays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  RaysAtHeights rays(made.box);
  const auto first = renderer.cast(rays.at(0), rays.get());
  CastTicket other = renderer.submitCast(rays.at(1), rays.get());
  CastTicket again = renderer.submitCast(rays.at(2), rays.get(), {"distance"}, {}, first);
  const auto stored = again.takeArrays();
  EXPECT_FLOAT_EQ(valuesIn<float>(first.at("distance"))[0], 7);
  EXPECT_EQ(valuesIn<float>(stored.at("distance")), valuesIn<float>(first.at("distance")));
  expectHeight(other, 1);
}

// Arrays of the caller have the bytes of those on the device, and nothing is stored before the ticket is taken.
TEST(WorldCast, StoresHitsInArraysOfTheCaller) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  RaysAtHeights rays(made.box);
  constexpr size_t kCount = 2 * RaysAtHeights::kRays;
  const auto placedHits = renderer.cast(rays.at(1), rays.get(), {"distance", "uv", "id", "normal"});
  std::vector<float> distance(kCount, -1), again(kCount, -1);
  std::vector<std::array<float, 2>> uv(kCount);
  std::vector<std::array<float, 3>> normal(kCount);
  std::vector<uint32_t> id(kCount);
  const CastTargets targets{.distance = distance.data(), .normal = normal.data(), .uv = uv.data(), .id = id.data()};
  CastTicket ticket = renderer.submitCast(rays.at(1), rays.get(), targets);
  renderer.cast(rays.at(2), rays.get(), CastTargets{.distance = again.data()});
  for (size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(distance[i], -1);
    ASSERT_FLOAT_EQ(again[i], 7 - static_cast<float>(i / RaysAtHeights::kRays));
  }
  ticket.take();
  EXPECT_EQ(distance, valuesIn<float>(placedHits.at("distance")));
  EXPECT_EQ(id, valuesIn<uint32_t>(placedHits.at("id")));
  const auto uvs = valuesIn<float>(placedHits.at("uv")), normals = valuesIn<float>(placedHits.at("normal"));
  EXPECT_EQ(std::memcmp(uv.data(), uvs.data(), uvs.size() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(normal.data(), normals.data(), normals.size() * sizeof(float)), 0);
  EXPECT_EQ(normal.front(), (std::array<float, 3>{0, 0, 1}));
  renderer.cast(rays.at(0), WorldRays{numbersIn(rays.origins), numbersIn(rays.directions), 0}, targets);
  renderer.cast(rays.at(0), rays.get(), CastTargets{});
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
}

TEST(WorldCast, TicketsOutliveTheirRenderer) {
  const BoxScene made;
  std::optional<Renderer> renderer(std::in_place, made.scene, testDevice());
  RaysAtHeights rays(made.box);
  CastTicket ticket = renderer->submitCast(rays.at(-1), rays.get());
  renderer.reset();
  expectHeight(ticket, -1);
}

// The device ends while it casts rays that nobody needs.
TEST(WorldCast, TicketsMayBeDroppedWithTheirRenderer) {
  const BoxScene made;
  RaysAtHeights rays(made.box);
  Renderer renderer(made.scene, testDevice());
  const std::vector<std::array<double, 3>> origins(200'000, {0, 0, 10}), directions(200'000, {0, 0, -1});
  std::vector<float> distances(origins.size());
  const CastTicket hosts = renderer.submitCast(origins, directions, CastTargets{.distance = distances.data()});
  const CastTicket ticket = renderer.submitCast(rays.at(0), rays.get());
  EXPECT_FALSE(ticket.done() && !hosts.done()) << "calls finish in order";
}

// A call in flight holds the device's memory that it reads, also if its ticket is dropped, and releases it then.
TEST(WorldCast, HoldsTheMemoryOfItsRays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  if (!renderer.inputArray(16)->host()) GTEST_SKIP() << "the host writes no memory of this device";
  constexpr uint64_t kRays = 400'000, kBytes = kRays * 3 * sizeof(float);
  const auto filled = [&](float x, float y, float z) {
    std::shared_ptr<const DeviceArray> array = renderer.inputArray(kBytes);
    auto* numbers = static_cast<float*>(const_cast<void*>(array->host()));
    for (uint64_t i = 0; i < kRays; ++i) numbers[3 * i] = x, numbers[3 * i + 1] = y, numbers[3 * i + 2] = z;
    return array;
  };
  const std::shared_ptr<const DeviceArray> down = filled(0, 0, -1);
  const auto submit = [&](const std::shared_ptr<const DeviceArray>& origins) {
    const WorldRays rays{{.device = origins}, {.device = down}, kRays};
    return renderer.submitCast(Worlds{.count = 1}, rays);
  };
  std::shared_ptr<const DeviceArray> origins = filled(0.5f, 0.25f, 10);
  const void* const memory = origins->host();
  CastTicket first = submit(std::exchange(origins, nullptr)), second = submit(filled(0.5f, 0.25f, 7));
  const std::shared_ptr<const DeviceArray> other = filled(9, 9, 9);
  EXPECT_NE(other->host(), memory);
  { const CastTicket dropped = std::move(first); }
  const std::shared_ptr<const DeviceArray> next = renderer.inputArray(kBytes);
  if (!second.done()) {
    EXPECT_NE(next->host(), memory);
  }
  for (const float distance : valuesIn<float>(second.takeArrays().at("distance"))) ASSERT_FLOAT_EQ(distance, 6);
  renderer.finish();
  const std::shared_ptr<const DeviceArray> later[] = {renderer.inputArray(kBytes), renderer.inputArray(kBytes),
                                                      renderer.inputArray(kBytes)};
  const auto isMemory = [&](const auto& array) { return array->host() == memory; };
  EXPECT_TRUE(isMemory(next) || std::ranges::any_of(later, isMemory)) << "it was not released";
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
}

TEST(WorldCast, TicketsReportErrorsInOneSentence) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  RaysAtHeights rays(made.box);
  CastTicket ticket = renderer.submitCast(rays.at(0), rays.get());
  EXPECT_THAT(rejectionOf([&] { ticket.take(); }), HasSubstr("these hits are arrays on the device"));
  expectHeight(ticket, 0);
  EXPECT_THAT(rejectionOf([&] { ticket.takeArrays(); }), HasSubstr("taken already"));
  const std::vector<std::array<double, 3>> origin{{0, 0, 10}}, direction{{0, 0, -1}};
  float distance = 0;
  CastTicket own = renderer.submitCast(origin, direction, CastTargets{.distance = &distance});
  EXPECT_THAT(rejectionOf([&] { own.takeArrays(); }), HasSubstr("these hits are no arrays on the device"));
  own.take();
  EXPECT_FLOAT_EQ(distance, 9);
  Worlds wrong = rays.at(0);
  rays.transforms[15 + 16] = 2;
  CastTicket invalid = renderer.submitCast(wrong, rays.get());
  EXPECT_THAT(rejectionOf([&] { invalid.takeArrays(); }), HasSubstr("the last row 0 0 0 1, and one of world 1"));
  std::vector<float> distances(2 * RaysAtHeights::kRays);
  CastTicket stored = renderer.submitCast(wrong, rays.get(), CastTargets{.distance = distances.data()});
  EXPECT_THAT(rejectionOf([&] { stored.takeArrays(); }), HasSubstr("these hits are no arrays on the device"));
  EXPECT_THAT(rejectionOf([&] { stored.take(); }), HasSubstr("the last row 0 0 0 1, and one of world 1"));
  const auto few = renderer.cast(rays.at(0), WorldRays{numbersIn(rays.origins), numbersIn(rays.directions), 5});
  EXPECT_THAT(rejectionOf([&] { renderer.submitCast(rays.at(0), rays.get(), {"distance"}, {}, few); }),
              HasSubstr("the array of distance is too small for the hits of 2000 rays"));
  CastTicket none = renderer.submitCast(rays.at(0), WorldRays{numbersIn(rays.origins), numbersIn(rays.directions), 0});
  EXPECT_TRUE(none.done());
  EXPECT_EQ(none.takeArrays().at("distance").shape, (std::array<uint64_t, 4>{1, 2, 0, 1}));
}

TEST(WorldCast, RejectsMalformedArrays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<float> rays(5);
  const auto rejected = [&](auto change) {
    WorldRays changed = rays.get();
    change(changed.directions);
    return rejectionOf([&] { renderer.cast(Worlds{.count = 1}, changed); });
  };
  EXPECT_THAT(rejected([](WorldArray& array) { array.offset = 8; }),
              HasSubstr("WorldRays::directions must begin at a multiple of 16 bytes"));
  EXPECT_THAT(rejected([](WorldArray& array) { array.device = std::make_shared<DeviceArray>(); }),
              HasSubstr("WorldRays::directions must be in one memory only"));
  EXPECT_THAT(rejected([](WorldArray& array) { array.element = WorldArray::Element::Int32; }),
              HasSubstr("WorldRays::directions must have elements of the type Float32 or Float64"));
  EXPECT_THAT(rejected([](WorldArray& array) { array.element = WorldArray::Element::Float64; }),
              HasSubstr("must have elements of the same type"));
}

// A device's addresses are invalid in another renderer's device.
TEST(WorldCast, RejectsArraysOfAnotherRenderer) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice()), other(made.scene, testDevice());
  if (!other.inputArray(16)->host()) GTEST_SKIP() << "the host writes no memory of this device";
  const std::shared_ptr<const DeviceArray> foreign = other.inputArray(1024);
  const ParallelRays<float> rays(5);
  WorldRays origins = rays.get(), directions = rays.get();
  origins.origins = {.device = foreign};
  directions.directions = {.device = foreign};
  EXPECT_THAT(rejectionOf([&] { renderer.cast(Worlds{.count = 1}, origins); }),
              HasSubstr("WorldRays::origins belongs to another renderer"));
  EXPECT_THAT(rejectionOf([&] { renderer.cast(Worlds{.count = 1}, directions); }),
              HasSubstr("WorldRays::directions belongs to another renderer"));
  Worlds worlds{.count = 1, .instances = {made.box}, .cameras = {Camera{}}};
  worlds.arrays.transforms.device = foreign;
  EXPECT_THAT(rejectionOf([&] { renderer.cast(worlds, rays.get()); }),
              HasSubstr("Worlds::arrays.transforms belongs to another renderer"));
  EXPECT_THAT(rejectionOf([&] { renderer.render(worlds); }),
              HasSubstr("Worlds::arrays.transforms belongs to another renderer"));
  origins.origins = {.device = std::make_shared<DeviceArray>()};
  EXPECT_THAT(rejectionOf([&] { renderer.cast(Worlds{.count = 1}, origins); }),
              HasSubstr("WorldRays::origins is empty"));
}

TEST(WorldCast, RejectsRaysThatExtendBeyondTheirMemory) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<float> rays(4);
  constexpr uint64_t kBytes = 5 * 4 * 3 * sizeof(float);  // of five worlds
  const std::shared_ptr<const DeviceArray> memory = renderer.inputArray(kBytes);
  if (!memory->host()) GTEST_SKIP() << "the host writes no memory of this device";
  const auto resultOf = [&](uint64_t offset) {
    WorldRays from = rays.get();
    from.origins = {.device = memory, .offset = offset};
    return rejectionOf([&] { renderer.cast(movedBoxes(made.box), from); });
  };
  EXPECT_EQ(resultOf(0), "nothing was rejected");
  for (const uint64_t offset : {uint64_t{16}, kBytes, uint64_t{1} << 40, ~uint64_t{0} - 15})
    EXPECT_EQ(resultOf(offset), "the rays of worlds extend beyond their memory") << offset;
  for (const uint64_t bytes : {uint64_t{1} << 60, ~uint64_t{0} - 15, ~uint64_t{0}})
    EXPECT_THROW(renderer.inputArray(bytes), Error) << bytes;
}

TEST(WorldCast, RejectsWrongArrays) {
  const BoxScene made;
  Renderer renderer(made.scene, testDevice());
  const ParallelRays<float> floats(5);
  const ParallelRays<double> doubles(5);
  const auto refused = [&](const std::function<void(WorldRays&)>& change, const std::string& output = "distance") {
    WorldRays rays = floats.get();
    change(rays);
    return rejectionOf([&] { renderer.cast(movedBoxes(made.box), rays, {output}); });
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
