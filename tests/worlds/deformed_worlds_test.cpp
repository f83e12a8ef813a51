// Worlds that pose the joints of skins and move the vertices of meshes: each has the bytes of the animated or edited
// scene, and the normals of deformed meshes are those of geometry.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>

#include "long_tests.h"
#include "models/models.h"
#include "render/submit/session.h"
#include "scene/load/load.h"
#include "scene/vertex_fans.h"
#include "scene/vertices.h"
#include "test_device.h"
#include "worlds/joint_arrays.h"
#include "worlds/same_frames.h"

namespace latelight {
namespace {

using glm::dmat4;
using glm::vec3;
using test::JointArrays;
using test::testDevice;

constexpr float kAspect = 4.0f / 3;

Options optionsOf(const char* raster, const char* shadows) {
  Options o;
  o.width = 40;
  o.height = 30;
  o.raster = raster;
  o.shadows = shadows;
  if (o.shadows == "rays") o.indirect = "one-bounce";
  o.samples = 1;
  for (const OutputInfo& output : outputInfos())
    if (!output.name.starts_with("raster")) o.aovs.push_back(output.name);
  return o;
}

void erase(Options& o, std::initializer_list<const char*> outputs) {
  for (const char* output : outputs) std::erase(o.aovs, output);
}

template <typename T>
WorldArray arrayOf(const std::vector<T>& numbers, uint32_t rows = 4) {
  return {.element = sizeof(T) == 8 ? WorldArray::Element::Float64 : WorldArray::Element::Float32,
          .rows = rows,
          .host = numbers.data()};
}

struct Case {
  const char* raster;
  const char* shadows;  // "none" and "rays": shaders place the worlds with the raster compute
};

class DeformedWorlds : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(Rasters, DeformedWorlds,
                         testing::Values(Case{"compute", "none"}, Case{"compute", "d32"}, Case{"hardware", "d32"},
                                         Case{"compute", "rays"}),
                         [](const auto& info) { return std::string(info.param.raster) + "_" + info.param.shadows; });

// --- joints ----------------------------------------------------------------------------------------------------------

// Poses of an animation, given as transforms of joints, have the bytes of the animation.
TEST_P(DeformedWorlds, PosedByJointsAreTheAnimation) {
  const auto count = test::rounds(100u, 5u);
  const std::string file = models::modelPath("skinned.glb").string();
  const scene::Scene internal = scene::load(file);
  Scene scene(file), animated(file);
  const std::vector<std::string> joints = scene.joints(scene.instances()[0]);
  ASSERT_FALSE(joints.empty());
  Worlds worlds{.count = count, .joints = joints, .cameras = {scene.defaultCamera(kAspect)}};
  Options o = optionsOf(GetParam().raster, GetParam().shadows);
  o.sun = Sun{.azimuth = 40, .elevation = 50};
  const auto timeOf = [&](uint32_t world) { return 0.06 + 0.88 * (world + 0.3) / count; };
  JointArrays arrays;
  for (uint32_t world = 0; world < count; ++world) {
    render::Settings settings;
    settings.time = timeOf(world);
    settings.animation = "bend";
    arrays.add(internal, joints, render::posesAt(internal, settings));
  }
  worlds.arrays.jointTransforms = arrayOf(arrays.numbers[0]);
  worlds.arrays.previousJointTransforms = arrayOf(arrays.numbers[1]);
  worlds.arrays.nextJointTransforms = arrayOf(arrays.numbers[2]);
  Renderer renderer(scene, testDevice(), "studio"), alone(animated, testDevice(), "studio");
  const std::vector<Frame> atRest = renderer.render(worlds.cameras, o);
  for (int call = 0; call < 3; ++call) {
    const std::vector<Frame> frames = renderer.render(worlds, o);
    ASSERT_EQ(frames.size(), count);
    for (uint32_t world = 0; world < count && !HasFailure(); ++world) {
      SCOPED_TRACE(testing::Message() << "world " << world << ", call " << call);
      Options posed = o;
      posed.animation = "bend";
      posed.time = timeOf(world);
      test::expectSameFrames(frames[world], alone.render(worlds.cameras[0], posed));
    }
    EXPECT_NE(frames[0].rgba, atRest[0].rgba);
  }
  // Joints that are not listed have the scene's pose, and a frame without worlds is not affected.
  worlds.joints.resize(1);
  JointArrays first;
  Options posed = o;
  posed.animation = "bend";
  posed.time = timeOf(2);
  for (uint32_t world = 0; world < count; ++world) {
    render::Settings settings;
    settings.time = posed.time;
    settings.animation = posed.animation;
    first.add(internal, worlds.joints, render::posesAt(internal, settings));
  }
  worlds.arrays.jointTransforms = arrayOf(first.numbers[0]);
  worlds.arrays.previousJointTransforms = arrayOf(first.numbers[1]);
  worlds.arrays.nextJointTransforms = arrayOf(first.numbers[2]);
  const std::vector<Frame> frames = renderer.render(worlds, posed);
  test::expectSameFrames(frames[count - 1], alone.render(worlds.cameras[0], posed));
  test::expectSameFrames(renderer.render(worlds.cameras, o)[0], atRest[0]);
}

// A file without animations keeps its skins, and worlds pose them. The joints are moved as one, so each vertex moves by
// the same distance, also far beyond the bounds at rest.
TEST_P(DeformedWorlds, PoseSkinsWithoutAnimations) {
  const std::string file = models::modelPath("static_skin.glb").string();
  const scene::Scene internal = scene::load(file);
  Scene scene(file);
  const std::vector<std::string> joints = scene.joints(scene.instances()[0]);
  ASSERT_FALSE(joints.empty());
  std::vector<float> numbers;
  const double right[] = {0, 0.25, 40};
  const scene::Pose rest = scene::restPose(internal);
  for (const double distance : right) {
    JointArrays one;
    render::Poses poses{rest, rest, rest};
    for (dmat4& world : poses.current.world) world = glm::translate(dmat4(1), glm::dvec3(distance, 0, 0)) * world;
    one.add(internal, joints, poses);
    for (size_t i = 0; i < one.numbers[0].size(); ++i)
      if (i % 16 < 12) numbers.push_back(static_cast<float>(one.numbers[0][i]));
  }
  Worlds worlds{.count = 3, .joints = joints, .cameras = {scene.defaultCamera(kAspect)}};
  worlds.arrays.jointTransforms = arrayOf(numbers, 3);
  for (uint32_t world = 0; world < 3; ++world) {
    Transform pose = worlds.cameras[0].cameraToWorld;
    pose[3] += right[world];
    worlds.cameraToWorld.push_back(pose);
  }
  Options o = optionsOf(GetParam().raster, GetParam().shadows);
  o.aovs = {"depth", "normal", "id"};
  Renderer renderer(scene, testDevice(), "studio");
  const std::vector<Frame> frames = renderer.render(worlds, o);
  const Frame atRest = renderer.render(worlds.cameras[0], o);
  for (const Frame& frame : frames) {
    size_t covered = 0, differ = 0;
    for (size_t i = 0; i < atRest.aovs.at("depth").values.size(); ++i) {
      const float depth = frame.aovs.at("depth").values[i], expected = atRest.aovs.at("depth").values[i];
      covered += std::isfinite(expected);
      differ += std::isfinite(depth) != std::isfinite(expected);
      if (std::isfinite(depth) && std::isfinite(expected)) {
        EXPECT_NEAR(depth, expected, 1e-3f);  // 40 m away, floats place the camera's rays less precisely
      }
    }
    EXPECT_GT(covered, 40u);
    EXPECT_LE(differ, 2u);  // at the silhouette
  }
}

// Joints that mirror the figure, seen by the mirrored camera, give the mirrored image: front faces stay front faces.
TEST_P(DeformedWorlds, TurnOverIfJointsMirror) {
  const scene::Scene internal = scene::load(models::modelPath("static_skin.glb").string());
  Scene scene(models::modelPath("static_skin.glb").string());
  JointArrays mirrored;
  const scene::Pose rest = scene::restPose(internal);
  render::Poses poses{rest, rest, rest};
  const dmat4 mirror = glm::scale(dmat4(1), glm::dvec3(-1, 1, 1));
  for (dmat4& world : poses.current.world) world = mirror * world;
  Worlds worlds{.count = 1, .joints = scene.joints(scene.instances()[0]), .cameras = {scene.defaultCamera(kAspect)}};
  mirrored.add(internal, worlds.joints, poses);
  worlds.arrays.jointTransforms = arrayOf(mirrored.numbers[0]);
  Options o = optionsOf(GetParam().raster, GetParam().shadows);
  o.aovs = {"depth"};
  Renderer renderer(scene, testDevice(), "studio");
  const std::vector<float> expected = renderer.render(worlds.cameras[0], o).aovs.at("depth").values;
  Transform& pose = worlds.cameras[0].cameraToWorld;
  for (const size_t i : {1, 2, 3, 4, 8}) pose[i] = -pose[i];  // mirrors the world, and the camera's X axis
  const std::vector<float> depth = renderer.render(worlds, o)[0].aovs.at("depth").values;
  size_t covered = 0, differ = 0;
  for (size_t i = 0; i < depth.size(); ++i) {
    const float a = depth[i], b = expected[i / o.width * o.width + o.width - 1 - i % o.width];
    covered += std::isfinite(b);
    differ += std::isfinite(a) != std::isfinite(b) || (std::isfinite(a) && std::abs(a - b) > 1e-4f);
  }
  EXPECT_GT(covered, 40u);
  EXPECT_LE(differ, 2u);  // at the silhouette
}

// --- vertices --------------------------------------------------------------------------------------------------------

// A random smooth motion of the vertices, in floats.
std::vector<std::array<float, 3>> wavy(const std::vector<std::array<float, 3>>& rest, std::mt19937& random) {
  std::uniform_real_distribution<float> wave(0.5f, 3), phase(0, 6), size(0.02f, 0.15f);
  std::vector<std::array<float, 3>> moved = rest;
  const float f = wave(random), p = phase(random), s = size(random);
  for (std::array<float, 3>& v : moved) {
    const std::array<float, 3> at = v;
    for (size_t axis = 0; axis < 3; ++axis) v[axis] += s * std::sin(f * at[(axis + 1) % 3] + p);
  }
  return moved;
}

// Returns a vector of the same direction that setMesh(), which normalizes normals and tangents, turns into this one.
template <typename Vector, typename Repair>
Vector beforeRepair(const Vector& unit, const Repair& repair) {
  for (int i = 0; i < 4096; ++i) {
    Vector before = unit;
    for (int axis = 0; axis < 3; ++axis) before[axis] *= 1 + static_cast<float>(i) / 4096;
    if (repair(before) == unit) return before;
  }
  ADD_FAILURE() << "no vector has this direction";
  return unit;
}

glm::vec4 repairedTangent(const glm::vec4& tangent) {
  std::vector<glm::vec4> one{tangent};
  scene::repairTangents(one);
  return one[0];
}

MeshData movedData(const Scene& scene, Handle<Mesh> mesh, const std::vector<std::array<float, 3>>& positions) {
  MeshData data = scene.meshData(mesh);
  scene::Vertices vertices;
  for (const auto& [x, y, z] : data.positions) vertices.positions.emplace_back(x, y, z);
  for (const auto& [x, y, z] : data.normals) vertices.normals.emplace_back(x, y, z);
  for (const auto& [x, y, z, w] : data.tangents) vertices.tangents.emplace_back(x, y, z, w);
  const scene::Mesh rest = scene::pack(std::move(vertices), data.indices);
  std::vector<vec3> moved;
  for (const auto& [x, y, z] : positions) moved.emplace_back(x, y, z);
  const auto attributes = scene::movedAttributes(rest, scene::vertexFans(rest), moved);
  data.positions = positions;
  for (size_t i = 0; i < attributes.size(); ++i) {
    const vec3 n = beforeRepair(attributes[i].normal, [](const vec3& v) { return glm::normalize(v); });
    data.normals[i] = {n.x, n.y, n.z};
    if (data.tangents.empty()) continue;
    const glm::vec4 t = beforeRepair(attributes[i].tangent, repairedTangent);
    data.tangents[i] = {t.x, t.y, t.z, t.w};
  }
  return data;
}

// Moved vertices have the bytes of the scene whose meshes are replaced.
TEST_P(DeformedWorlds, WithMovedVerticesAreTheEditedScene) {
  const auto count = test::rounds(200u, 3u);
  for (const char* name : {"textured.glb", "blended.glb"}) {
    SCOPED_TRACE(name);
    const std::string file = models::modelPath(name).string();
    Scene scene(file), edited(file);
    for (Scene* each : {&scene, &edited})  // setMesh() computes tangents that files lack
      for (const Handle<Mesh> mesh : each->meshes()) each->setMesh(mesh, each->meshData(mesh));
    Worlds worlds{.count = count, .cameras = {scene.defaultCamera(kAspect)}};
    worlds.meshes = scene.meshes();
    if (worlds.meshes.size() > 2) worlds.meshes.resize(2);
    std::mt19937 random(4);
    std::vector<std::vector<std::vector<std::array<float, 3>>>> positions(count);
    std::vector<float> numbers;
    for (uint32_t world = 0; world < count; ++world)
      for (const Handle<Mesh> mesh : worlds.meshes) {
        positions[world].push_back(wavy(scene.meshData(mesh).positions, random));
        for (const auto& vertex : positions[world].back()) numbers.insert(numbers.end(), vertex.begin(), vertex.end());
      }
    const std::vector<double> doubles(numbers.begin(), numbers.end());
    Options o = optionsOf(GetParam().raster, GetParam().shadows);
    o.sun = Sun{.azimuth = 40, .elevation = 50};
    o.aoRadius = 0.1f;
    o.ambientOcclusion = "gtao";
    // Coordinates and curvature are those at rest, which worlds do not change and edits do.
    erase(o, {"object-position", "nocs", "curvature"});
    Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
    const std::vector<Frame> atRest = renderer.render(worlds.cameras, o);
    for (int call = 0; call < 3; ++call) {
      worlds.arrays.vertices = call == 1 ? arrayOf(doubles, 3) : arrayOf(numbers, 3);
      const std::vector<Frame> frames = renderer.render(worlds, o);
      ASSERT_EQ(frames.size(), count);
      for (uint32_t world = 0; world < count && !HasFailure(); ++world) {
        SCOPED_TRACE(testing::Message() << "world " << world << ", call " << call);
        for (size_t i = 0; i < worlds.meshes.size(); ++i)
          edited.setMesh(edited.meshes()[i], movedData(scene, worlds.meshes[i], positions[world][i]));
        test::expectSameFrames(frames[world], alone.render(worlds.cameras[0], o));
        EXPECT_NE(frames[world].rgba, atRest[0].rgba);
      }
    }
    test::expectSameFrames(renderer.render(worlds.cameras, o)[0], atRest[0]);
  }
}

// The normals of a mesh without seams are those that setMesh() computes where a normal is 0.
TEST_P(DeformedWorlds, HaveTheNormalsOfTheEditedScene) {
  Scene scene, edited;
  MeshData cloth{.name = "cloth"};
  constexpr uint32_t kSide = 9;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    cloth.positions.push_back(
        {0.25f * static_cast<float>(i % kSide) - 1, 0.25f * static_cast<float>(i / kSide) - 1, 0});
    cloth.normals.push_back({0, 0, 1});
    if (i % kSide == kSide - 1 || i / kSide == kSide - 1) continue;
    cloth.indices.insert(cloth.indices.end(), {i, i + 1, i + kSide, i + 1, i + kSide + 1, i + kSide});
  }
  for (Scene* each : {&scene, &edited}) {
    each->addInstance(each->addMesh(cloth), each->addMaterial({.doubleSided = true}),
                      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    each->addLight({.position = {1, 2, 3}, .intensity = 40});
  }
  constexpr uint32_t kWorlds = 8;
  Worlds worlds{.count = kWorlds, .meshes = scene.meshes(), .cameras = {scene.lookAt({0, -2, 3}, {0, 0, 0})}};
  std::mt19937 random(6);
  std::vector<std::vector<std::array<float, 3>>> positions;
  std::vector<float> numbers;
  for (uint32_t world = 0; world < kWorlds; ++world)
    for (const auto& vertex : positions.emplace_back(wavy(cloth.positions, random)))
      numbers.insert(numbers.end(), vertex.begin(), vertex.end());
  worlds.arrays.vertices = arrayOf(numbers, 3);
  Options o = optionsOf(GetParam().raster, GetParam().shadows);
  erase(o, {"object-position", "nocs", "curvature"});
  Renderer renderer(scene, testDevice()), alone(edited, testDevice());
  const std::vector<Frame> frames = renderer.render(worlds, o);
  for (uint32_t world = 0; world < kWorlds && !HasFailure(); ++world) {
    SCOPED_TRACE(world);
    MeshData moved = cloth;
    moved.positions = positions[world];
    moved.normals.assign(moved.positions.size(), {0, 0, 0});
    edited.setMesh(edited.meshes()[0], moved);
    test::expectSameFrames(frames[world], alone.render(worlds.cameras[0], o));
  }
}

// A square of 2 m that fills the image of an orthographic camera, 16 pixels per meter.
struct Square {
  Scene scene;
  Handle<Mesh> mesh;
  Camera camera{.cameraToWorld = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 4, 0, 0, 0, 1},
                .orthographic = true,
                .nearClip = 0.125f,
                .farClip = 16};
  std::vector<float> numbers{-3, -3, 0, 3, -3, 0, 3, 3, 0, -3, 3, 0};

  Square() {
    MeshData data{.name = "square", .indices = {0, 1, 2, 0, 2, 3}};
    for (size_t i = 0; i < 4; ++i) {
      data.positions.push_back({numbers[3 * i], numbers[3 * i + 1], 0});
      data.normals.push_back({0, 0, 1});
    }
    mesh = scene.addMesh(data);
    scene.addInstance(mesh, scene.addMaterial({.unlit = true}), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  }
  // The square's vertices, moved to the right in each world.
  std::vector<float> moved(std::initializer_list<float> right) const {
    std::vector<float> all;
    for (const float x : right)
      for (size_t i = 0; i < numbers.size(); ++i) all.push_back(numbers[i] + (i % 3 == 0 ? x : 0));
    return all;
  }
};

// Motion follows from the distance by which the vertices move: 16 pixels per meter.
TEST_P(DeformedWorlds, HaveTheMotionOfTheirVertices) {
  Square square;
  Renderer renderer(square.scene, testDevice());
  Worlds worlds{.count = 2, .meshes = {square.mesh}, .cameras = {square.camera}};
  const std::vector<float> now = square.moved({0, 0}), previous = square.moved({-0.25f, 0.5f}),
                           next = square.moved({0.125f, 0});
  worlds.arrays.vertices = arrayOf(now, 3);
  worlds.arrays.previousVertices = arrayOf(previous, 3);
  worlds.arrays.nextVertices = arrayOf(next, 3);
  Options o;
  o.width = o.height = 32;
  o.raster = GetParam().raster;
  o.shadows = GetParam().shadows;
  o.aovs = {"motion"};
  const std::vector<Frame> frames = renderer.render(worlds, o);
  const float expected[2][4] = {{-4, 0, 2, 0}, {8, 0, 0, 0}};  // to the previous and the next position, in pixels
  for (size_t world = 0; world < 2; ++world)
    for (size_t i = 0; i < 4 * 32 * 32; ++i)
      ASSERT_NEAR(frames[world].aovs.at("motion").values[i], expected[world][i % 4], 1e-4) << world << ", " << i;
}

// A world with a NaN in its vertices or joints is reported and empty, and the others are unaffected.
TEST_P(DeformedWorlds, AreEmptyIfAValueIsNotFinite) {
  Square square;
  Renderer renderer(square.scene, testDevice());
  Worlds worlds{.count = 3, .meshes = {square.mesh}, .cameras = {square.camera}};
  std::vector<float> now = square.moved({0, 0.1f, 0.2f});
  worlds.arrays.vertices = arrayOf(now, 3);
  Options o = optionsOf(GetParam().raster, GetParam().shadows);
  o.aovs = {"id"};
  const std::vector<Frame> expected = renderer.render(worlds, o);
  const auto expectEmpty = [&](Renderer& of, const std::vector<Frame>& without, uint32_t empty) {
    Ticket ticket = of.submit(worlds, o);
    EXPECT_EQ(ticket.invalidWorlds(), std::vector{empty});
    const std::vector<Frame> frames = ticket.take();
    for (uint32_t world = 0; world < 3; ++world)
      if (world != empty) test::expectSameFrames(frames[world], without[world]);
    EXPECT_THAT(frames[empty].aovs.at("id").ids, testing::Each(0u));
  };
  now[12 + 5] = std::nanf("");
  expectEmpty(renderer, expected, 1);
  now[12 + 5] = 0;
  std::vector<float> previous = now;
  previous.back() = std::numeric_limits<float>::infinity();
  worlds.arrays.previousVertices = arrayOf(previous, 3);
  expectEmpty(renderer, expected, 2);

  Scene skinned(models::modelPath("skinned.glb").string());
  Renderer other(skinned, testDevice());
  const std::vector<std::string> joints = skinned.joints(skinned.instances()[0]);
  std::vector<double> numbers(16 * 3 * joints.size());
  for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = i % 16 % 5 == 0 ? 1 : 0;
  worlds = {.count = 3, .joints = joints, .cameras = {skinned.defaultCamera(kAspect)}};
  worlds.arrays.jointTransforms = arrayOf(numbers);
  const std::vector<Frame> finite = other.render(worlds, o);
  numbers[3] = std::nan("");
  expectEmpty(other, finite, 0);
  numbers[3] = 0;
  numbers[15] = 2;  // not affine
  EXPECT_THROW(other.render(worlds, o), Error);
}

TEST(DeformedWorldsApi, RejectWrongLists) {
  Square square;
  Renderer renderer(square.scene, testDevice());
  const std::vector<float> now = square.moved({0});
  const Worlds valid{
      .count = 1, .meshes = {square.mesh}, .cameras = {square.camera}, .arrays = {.vertices = arrayOf(now, 3)}};
  Options o = optionsOf("auto", "none");
  o.aovs = {};
  renderer.render(valid, o);
  const auto expectError = [&](const char* part, const auto& change) {
    Worlds worlds = valid;
    change(worlds);
    try {
      renderer.render(worlds, o);
      ADD_FAILURE() << part;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(part));
    }
  };
  expectError("require each other", [](Worlds& w) { w.arrays.vertices = {}; });
  expectError("require each other", [](Worlds& w) { w.meshes.clear(); });
  expectError("require each other", [](Worlds& w) { w.joints = {"/a"}; });
  expectError("twice", [](Worlds& w) { w.meshes.push_back(w.meshes[0]); });
  expectError("require vertices", [&](Worlds& w) {
    w.meshes.clear();
    w.arrays.previousVertices = std::exchange(w.arrays.vertices, {});
  });
  expectError("no joint \"/square\"", [&](Worlds& w) {
    w.joints = {"/square"};
    w.arrays.jointTransforms = arrayOf(now);
  });
}

// --- normals ---------------------------------------------------------------------------------------------------------

constexpr int kCells = 8;  // per half of a grid

// A grid of 4 m x 2 m in the plane z = 0, whose two halves have vertices of their own along a seam at x = 0. Its
// texture coordinates follow x and y.
scene::Mesh gridWithSeam() {
  scene::Vertices vertices;
  std::vector<uint32_t> indices;
  const auto add = [&](int begin, int end) {
    const auto first = static_cast<uint32_t>(vertices.positions.size()), width = static_cast<uint32_t>(end - begin + 1);
    for (int y = 0; y <= kCells; ++y)
      for (int x = begin; x <= end; ++x) {
        vertices.positions.emplace_back(0.25f * static_cast<float>(x), 0.25f * static_cast<float>(y), 0);
        vertices.normals.emplace_back(0, 0, 1);
        vertices.uv[0].emplace_back(x, y);
      }
    for (uint32_t y = 0; y < kCells; ++y)
      for (uint32_t x = 0; x + 1 < width; ++x) {
        const uint32_t a = first + y * width + x, b = a + 1, c = a + width, d = c + 1;
        indices.insert(indices.end(), {a, b, c, b, d, c});
      }
  };
  add(-kCells, 0);
  add(0, kCells);
  return scene::makeMesh(vertices, indices);
}

// z = x^2 / 2. The differences of a parabola are exact, so a vertex inside has exactly the parabola's normal: the
// triangles on its two sides have equal areas seen from above.
scene::Mesh bentGrid() {
  scene::Mesh mesh = gridWithSeam();
  const scene::VertexFans fans = scene::vertexFans(mesh);
  for (vec3& p : mesh.positions) p.z = 0.5f * p.x * p.x;
  mesh.attributes = scene::movedAttributes(mesh, fans, mesh.positions);
  return mesh;
}

TEST(VertexFans, AreSmoothAcrossASeam) {
  const scene::Mesh mesh = bentGrid();
  size_t checked = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 p = mesh.positions[i], tangent(mesh.attributes[i].tangent);
    if (std::abs(p.x) == 0.25f * kCells || p.y == 0 || p.y == 0.25f * kCells) continue;  // at the border
    ++checked;
    EXPECT_LT(glm::length(mesh.attributes[i].normal - glm::normalize(vec3(-p.x, 0, 1))), 2e-6f);
    EXPECT_LT(glm::length(tangent - glm::normalize(vec3(1, 0, p.x))), 2e-6f);  // along u, which is x
  }
  EXPECT_EQ(checked, 2u * kCells * (kCells - 1));
}

// An affine map turns the area-weighted normal by its cofactor matrix and moves the tangent as any vector in the plane
// of the triangles.
TEST(VertexFans, FollowAffineMaps) {
  const scene::Mesh mesh = bentGrid();
  const glm::dmat3 map(1.2, 0.3, -0.2, 0.1, 0.7, 0.4, -0.5, 0.2, 1.6);
  const glm::dmat3 cofactors = glm::determinant(map) * glm::transpose(glm::inverse(map));
  std::vector<vec3> moved;
  for (const vec3& p : mesh.positions) moved.emplace_back(map * glm::dvec3(p));
  const auto attributes = scene::movedAttributes(mesh, scene::vertexFans(mesh), moved);
  for (size_t i = 0; i < attributes.size(); ++i) {
    const glm::dvec3 normal = glm::normalize(cofactors * glm::dvec3(mesh.attributes[i].normal));
    EXPECT_LT(glm::length(glm::dvec3(attributes[i].normal) - normal), 1e-5);
    const glm::dvec3 image = map * glm::dvec3(vec3(mesh.attributes[i].tangent));
    const glm::dvec3 tangent = glm::normalize(image - normal * glm::dot(normal, image));
    EXPECT_LT(glm::length(glm::dvec3(vec3(attributes[i].tangent)) - tangent), 1e-5) << i;
    EXPECT_EQ(attributes[i].tangent.w, mesh.attributes[i].tangent.w);
    EXPECT_EQ(attributes[i].uv0, mesh.attributes[i].uv0);
  }
}

// The faces of a box share no normals at rest, so its edges stay creases.
TEST(VertexFans, KeepCreases) {
  scene::Vertices vertices;
  for (const vec3 p : {vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(1, 0, 0), vec3(1, 0, -1), vec3(1, 1, 0)})
    vertices.positions.push_back(p);
  const scene::Mesh mesh = scene::makeMesh(vertices, {0, 1, 2, 3, 4, 5});
  std::vector<vec3> moved = mesh.positions;
  for (vec3& p : moved) p = vec3(p.x, p.y, 0.5f * p.z);
  const auto attributes = scene::movedAttributes(mesh, scene::vertexFans(mesh), moved);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(attributes[i].normal, i < 3 ? vec3(0, 0, 1) : vec3(1, 0, 0));
}

}  // namespace
}  // namespace latelight
