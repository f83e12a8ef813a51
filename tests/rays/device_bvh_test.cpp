// BVHs that the device builds: their structure for any triangles, and the hits of rays, which are those with the BVHs
// of the host, to the byte. On a CPU device, these tests use the code paths for GPUs.
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "long_tests.h"
#include "models/models.h"
#include "rays/bvh_checks.h"
#include "render/rays/scene_bvh.h"
#include "render/rays/triangle_boxes.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "scene/scene_builder.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using glm::vec3;

using Triangles = std::vector<vec3>;  // three corners each

scene::Mesh meshOf(const Triangles& corners) {
  scene::Mesh mesh;
  mesh.positions = corners;
  for (uint32_t i = 0; i < corners.size(); ++i) {
    mesh.indices.push_back(i);
    mesh.attributes.push_back({vec3(0, 0, 1), glm::vec4(1, 0, 0, 1), glm::vec2(0)});
  }
  scene::findBounds(mesh);
  return mesh;
}

// Triangles whose corners lie in a cube of edge `extent` around random points of a box.
Triangles randomTriangles(size_t count, vec3 low, vec3 high, float extent, uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  const auto point = [&] {
    const float x = unit(random), y = unit(random), z = unit(random);
    return vec3(x, y, z);
  };
  Triangles corners;
  for (size_t i = 0; i < count; ++i) {
    const vec3 center = low + point() * (high - low);
    for (int corner = 0; corner < 3; ++corner) corners.push_back(center + extent * (point() - 0.5f));
  }
  return corners;
}

Triangles repeated(const Triangles& some, size_t times) {
  Triangles all;
  for (size_t i = 0; i < times; ++i) all.insert(all.end(), some.begin(), some.end());
  return all;
}

Triangles scaled(Triangles corners, float scale, vec3 offset = vec3(0)) {
  for (vec3& corner : corners) corner = corner * scale + offset;
  return corners;
}

// A row of triangles whose sizes and distances grow by a factor: a tree of nearest neighbors would be a chain.
Triangles growing(size_t count, float factor) {
  Triangles corners;
  float at = 1;
  for (size_t i = 0; i < count; ++i, at *= factor)
    for (const vec3& corner : {vec3(0), vec3(0.1f, 0, 0), vec3(0, 0.1f, 0)}) corners.push_back(at * (corner + 1.0f));
  return corners;
}

Triangles slivers(size_t count) {
  Triangles corners;
  for (size_t i = 0; i < count; ++i) {
    const float angle = 0.1f * static_cast<float>(i);
    const vec3 direction(std::cos(angle), std::sin(angle), 0.3f);
    for (const vec3& corner : {-10.0f * direction, 10.0f * direction, 10.0f * direction + vec3(0, 0, 1e-4f)})
      corners.push_back(corner);
  }
  return corners;
}

struct NamedTriangles {
  const char* name;
  Triangles corners;
};

std::vector<NamedTriangles> kindsOfTriangles() {
  const Triangles one{vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)};
  const Triangles soup = randomTriangles(3000, vec3(-10), vec3(10), 1);
  std::vector<NamedTriangles> kinds{
      {"one", one},
      {"two", randomTriangles(2, vec3(-1), vec3(1), 1)},
      {"three", randomTriangles(3, vec3(-1), vec3(1), 1)},
      {"four apart", randomTriangles(4, vec3(-100), vec3(100), 1)},
      {"four together", randomTriangles(4, vec3(-0.01f), vec3(0.01f), 1)},
      {"five", randomTriangles(5, vec3(-1), vec3(1), 1)},
      {"225, one more than a workgroup merges", randomTriangles(225, vec3(-5), vec3(5), 1)},
      {"2049, one more than a workgroup sorts", randomTriangles(2049, vec3(-5), vec3(5), 1)},
      {"coincident", repeated(one, 1000)},
      {"a point", repeated({vec3(3), vec3(3), vec3(3)}, 700)},
      {"degenerate", repeated({vec3(0), vec3(1, 0, 0), vec3(2, 0, 0)}, 300)},
      {"soup", soup},
      {"large triangles among small ones", soup},
      {"a plane", randomTriangles(2000, vec3(-10, -10, 0), vec3(10, 10, 0), 0.3f)},
      {"a line", randomTriangles(2000, vec3(-1000, 0, 0), vec3(1000, 0, 0), 0.3f)},
      {"growing by 1.5", growing(180, 1.5f)},
      {"growing by 2", growing(100, 2)},
      {"growing by 1.02", growing(3000, 1.02f)},
      {"slivers", slivers(500)},
      {"huge", scaled(soup, 1e36f)},
      {"as large as floats", scaled(soup, 3e37f)},
      {"tiny", scaled(soup, 1e-30f)},
      {"denormal", scaled(soup, 1e-41f)},
      {"far from the origin", scaled(soup, 1, vec3(1e6f, -2e6f, 3e5f))},
      {"so far that many coincide", scaled(soup, 1, vec3(3e8f))},
  };
  const Triangles large = randomTriangles(300, vec3(-10), vec3(10), 30, 2);
  kinds[12].corners.insert(kinds[12].corners.end(), large.begin(), large.end());
  return kinds;
}

scene::Scene sceneOf(std::vector<scene::Mesh> meshes) {
  scene::SceneBuilder builder("meshes");
  scene::Material material;
  material.data.baseColor = glm::vec4(1);
  material.data.flags = shared::kMaterialDoubleSided;
  builder.scene.materials.push_back(material);
  for (scene::Mesh& mesh : meshes) {
    builder.scene.meshes.push_back(std::move(mesh));
    builder.addInstance("mesh", builder.kRoot, static_cast<uint32_t>(builder.scene.meshes.size()) - 1, 0, glm::mat4(1));
  }
  for (scene::Instance& instance : builder.scene.instances) instance.toWorld = glm::dmat4(1);
  return std::move(builder.scene);
}

std::vector<Box> boxesOf(const scene::Mesh& mesh) {
  const vec3 origin = scene::vertexOrigin(mesh);
  std::vector<Box> boxes(mesh.indices.size() / 3);
  for (size_t i = 0; i < mesh.indices.size(); ++i) boxes[i / 3].add(mesh.positions[mesh.indices[i]] - origin);
  return boxes;
}

template <typename T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

class DeviceBvhTest : public RenderTest {
 protected:
  static vk::Device& building() { return gpuPaths(); }

  static std::vector<Bvh> built(const scene::Scene& scene) {
    graph::Executor executor(building());
    GpuScene gpuScene(building(), scene);
    SceneBvh bvhs(building(), executor, scene, gpuScene);
    bvhs.update();
    std::vector<Bvh> read;
    for (uint32_t mesh = 0; mesh < scene.meshes.size(); ++mesh) read.push_back(bvhs.readMesh(mesh));
    return read;
  }

  static void expectSoundBvhs(const scene::Scene& scene) {
    const std::vector<Bvh> bvhs = built(scene);
    for (size_t i = 0; i < bvhs.size(); ++i) {
      SCOPED_TRACE(fmt::format("mesh {}", i));
      if (!triangleBoxes(scene.meshes[i]).triangles.empty()) continue;  // built by the host, from parts of triangles
      expectSound(bvhs[i], boxesOf(scene.meshes[i]), shared::kMaxRayLeaf, shared::kMaxMeshDepth);
    }
  }

  // Returns a point in a random triangle of a random visible instance, at rest.
  static dvec3 randomPoint(const scene::Scene& scene, std::mt19937& random) {
    const scene::Instance& instance = scene.instances[random() % scene.instances.size()];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const size_t first = random() % (mesh.indices.size() / 3) * 3;
    dvec3 center(0);
    for (size_t i = first; i < first + 3; ++i) center += dvec3(mesh.positions[mesh.indices[i]]) / 3.0;
    return dvec3(instance.toWorld * glm::dvec4(center, 1));
  }

  static Settings raySettings() {
    Settings settings = settingsOf(64, 36);
    settings.axes = Axes::ZUp;
    settings.dataSurfaces = DataSurfaces::Any;
    return settings;
  }

  // Half of the rays connect points of a sphere around the scene, and half of them start there and end at triangles.
  static void expectSameHits(const scene::Scene& scene, const std::vector<SceneState>& states = {{}},
                             size_t minHits = 10) {
    scene::Bounds bounds = GpuScene(building(), scene).bounds();
    const dvec3 center = 0.5 * (dvec3(bounds.min) + dvec3(bounds.max));
    const double radius = 0.6 * glm::length(dvec3(bounds.max) - dvec3(bounds.min));
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<dvec3> origins, directions;
    const auto point = [&] {
      const double x = normal(random), y = normal(random), z = normal(random);
      return radius * glm::normalize(dvec3(x, y, z));
    };
    for (int i = 0; i < 3000; ++i) {
      origins.push_back(center + point());
      const dvec3 target = i % 2 ? center + 0.7 * point() : randomPoint(scene, random);
      directions.push_back(target - origins.back());
    }
    Renderer onHost(device(), scene, nullptr), onDevice(building(), scene, nullptr);
    size_t hitCount = 0;
    for (const SceneState& state : states) {
      const CastHits a = onHost.cast({origins, directions}, raySettings(), state).hits;
      const CastHits b = onDevice.cast({origins, directions}, raySettings(), state).hits;
      EXPECT_TRUE(sameBytes(a.distance, b.distance));
      EXPECT_TRUE(sameBytes(a.triangle, b.triangle));
      EXPECT_TRUE(sameBytes(a.part, b.part));
      EXPECT_TRUE(sameBytes(a.position, b.position));
      EXPECT_TRUE(sameBytes(a.normal, b.normal));
      EXPECT_TRUE(sameBytes(a.geonormal, b.geonormal));
      EXPECT_TRUE(sameBytes(a.uv, b.uv));
      // A CPU device decodes sRGB by a polynomial, whose error is 7e-7.
      for (size_t i = 0; i < a.intensity.size(); ++i) ASSERT_NEAR(a.intensity[i], b.intensity[i], 3e-6f) << i;
      for (const float distance : b.distance) hitCount += std::isfinite(distance);
    }
    EXPECT_GE(hitCount, states.size() * minHits);
  }
};

TEST_F(DeviceBvhTest, IsSoundForAnyTriangles) {
  for (const NamedTriangles& kind : kindsOfTriangles()) {
    SCOPED_TRACE(kind.name);
    expectSoundBvhs(sceneOf({meshOf(kind.corners)}));
  }
}

TEST_F(DeviceBvhTest, IsSoundForManyMeshesAtOnce) {
  std::vector<scene::Mesh> meshes;
  for (const NamedTriangles& kind : kindsOfTriangles()) meshes.push_back(meshOf(kind.corners));
  for (uint32_t i = 0; i < 300; ++i) meshes.push_back(meshOf(randomTriangles(1 + i % 40, vec3(-1), vec3(1), 1, i)));
  expectSoundBvhs(sceneOf(std::move(meshes)));
}

TEST_F(DeviceBvhTest, IsTheSameEachTime) {
  const scene::Scene scene = sceneOf({meshOf(randomTriangles(20000, vec3(-10), vec3(10), 1)), sphereMesh(2)});
  const std::vector<Bvh> first = built(scene), second = built(scene);
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_TRUE(sameBytes(first[i].nodes, second[i].nodes));
    EXPECT_EQ(first[i].items, second[i].items);
  }
}

// A closed surface of 2 * rows^2 triangles.
Triangles bumpySphere(int rows) {
  std::mt19937 random(3);
  std::vector<vec3> points;
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j < rows; ++j) {
      const float down =
          std::numbers::pi_v<float> * (static_cast<float>(i) + 0.01f) / (static_cast<float>(rows) + 0.02f);
      const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(rows);
      const float radius = 10 + 0.8f * std::sin(9 * down) * std::cos(7 * around) +
                           0.3f * std::generate_canonical<float, 24>(random) * 20 / static_cast<float>(rows);
      points.push_back(radius *
                       vec3(std::sin(down) * std::cos(around), std::cos(down), std::sin(down) * std::sin(around)));
    }
  Triangles corners;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < rows; ++j) {
      const int next = (j + 1) % rows, a = i * rows + j, b = i * rows + next, c = a + rows, d = b + rows;
      for (const int corner : {a, c, b, b, c, d}) corners.push_back(points[static_cast<size_t>(corner)]);
    }
  return corners;
}

TEST_F(DeviceBvhTest, CostsLittleMoreThanThatOfTheHost) {
  for (const Triangles& corners :
       {randomTriangles(20000, vec3(-10), vec3(10), 0.5f),
        randomTriangles(20000, vec3(-10, -10, 0), vec3(10, 10, 0), 0.3f), bumpySphere(300)}) {
    const scene::Mesh mesh = meshOf(corners);
    const double host = sahCost(buildBvh(boxesOf(mesh), shared::kMaxRayLeaf, shared::kMaxMeshDepth));
    const double device = sahCost(built(sceneOf({mesh})).front());
    fmt::print("cost: host {:.3f}, device {:.3f}\n", host, device);
    EXPECT_LT(device, 1.1 * host);
  }
}

TEST_F(DeviceBvhTest, RaysHitTheSameInAnyTriangles) {
  const bool full = latelight::test::runsInFull();
  size_t number = 0;
  for (const NamedTriangles& kind : kindsOfTriangles()) {
    if (!full && number++ % 2 != 0) continue;
    const std::string name = kind.name;
    if (name.find("floats") != name.npos || name == "a point" || name == "degenerate" || name == "denormal") continue;
    SCOPED_TRACE(name);
    const bool measurable = name.find("growing") == name.npos && name != "huge" && name != "tiny" &&
                            name.find("coincide") == name.npos;  // otherwise few rays hit, or none
    expectSameHits(sceneOf({meshOf(kind.corners)}), {{}}, measurable ? 10 : 0);
  }
}

TEST_F(DeviceBvhTest, RaysHitTheSameInModels) {
  for (const auto& [name, bytes] : models::allModels()) {
    SCOPED_TRACE(name);
    if (name.starts_with("sky")) continue;
    const scene::Scene scene = scene::load(models::modelPath(name));
    std::vector<SceneState> states{{}};
    Settings settings;
    for (const double time : {0.3, 0.7}) {
      settings.time = time;
      states.push_back({.poses = posesAt(scene, settings)});
    }
    states.push_back({});
    expectSameHits(scene, states);
  }
  expectSameHits(scene::load("builtin:spheres"));
  expectSameHits(hall());
}

// Mirrored, sheared and flattened placements of one mesh.
TEST_F(DeviceBvhTest, RaysHitTheSameInPlacements) {
  scene::Scene scene = sceneOf(std::vector<scene::Mesh>(5, sphereMesh(1)));
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    glm::dmat4& toWorld = scene.instances[i].toWorld;
    toWorld[0][0] = i % 2 ? -1.3 : 0.8;
    toWorld[1][0] = 0.4 * static_cast<double>(i);
    toWorld[2][2] = i == 4 ? 0 : 1;
    toWorld[3] = glm::dvec4(3.0 * static_cast<double>(i), 1, 0, 1);
  }
  expectSameHits(scene);
}

TEST_F(DeviceBvhTest, FollowsEdits) {
  scene::Scene scene = sceneOf({sphereMesh(1), meshOf(randomTriangles(500, vec3(-3), vec3(3), 1))});
  Renderer renderer(building(), scene, nullptr);
  const std::vector<dvec3> origins{dvec3(0.01, 0.02, 20)}, directions{dvec3(0, 0, -1)};
  const auto distance = [&] { return renderer.cast({origins, directions}, raySettings()).hits.distance.front(); };
  distance();
  scene::removeInstance(scene, 1);
  EXPECT_NEAR(distance(), 19, 0.05);
  scene::setMesh(scene, 0, sphereMesh(5));
  EXPECT_NEAR(distance(), 15, 0.2);
}

// Refits keep the structure, and return to the boxes at rest.
TEST_F(DeviceBvhTest, RefitsReturnToRest) {
  const scene::Scene scene = scene::load(models::modelPath("morphed.glb"));
  graph::Executor executor(building());
  GpuScene gpuScene(building(), scene);
  SceneBvh bvhs(building(), executor, scene, gpuScene);
  const auto read = [&](const Poses& poses) {
    gpuScene.update(poses);
    bvhs.update();
    graph::Graph graph(executor);
    gpuScene.addChanges(graph);
    bvhs.addChanges(graph);
    executor.run(graph, graph.compile());
    gpuScene.changesSubmitted();
    bvhs.changesSubmitted();
    return bvhs.readMesh(0);
  };
  const Bvh rest = read({});
  Settings settings;
  settings.time = 0.5;
  const Bvh posed = read(posesAt(scene, settings)), again = read({});
  expectSound(rest, boxesOf(scene.meshes[0]), shared::kMaxRayLeaf, shared::kMaxMeshDepth);
  EXPECT_FALSE(sameBytes(rest.nodes, posed.nodes));
  EXPECT_TRUE(sameBytes(rest.nodes, again.nodes));
}

}  // namespace
}  // namespace latelight::render::test
