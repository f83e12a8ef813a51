// Scattered objects: their allowed positions, and their distances from each other.
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include "data/random.h"
#include "data/variations/oriented_box.h"
#include "data_variations/support.h"
#include "scene/objects.h"

namespace latelight::data::test {
namespace {

dvec3 nearestIn(const OrientedBox& box, dvec3 p) {
  dvec3 nearest = box.center;
  for (int axis = 0; axis < 3; ++axis) {
    const dvec3 half = box.half[axis];  // perpendicular to the others
    nearest += half * glm::clamp(glm::dot(p - box.center, half) / glm::dot(half, half), -1.0, 1.0);
  }
  return nearest;
}

// The distance of two boxes by alternating projection, which converges to their nearest points (Cheney and Goldstein
// 1959, "Proximity maps for convex sets").
double distanceBetween(const OrientedBox& a, const OrientedBox& b) {
  dvec3 p = a.center, q = b.center;
  for (int i = 0; i < 3000; ++i) q = nearestIn(b, p), p = nearestIn(a, q);
  return glm::length(p - q);
}

OrientedBox anyBox(Random& random) {
  const dvec3 u(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  const dvec3 v(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  const dvec3 x = glm::normalize(u), y = glm::normalize(glm::cross(u, v)), z = glm::cross(x, y);
  OrientedBox box{.half = {x * random.between(0.1, 1), y * random.between(0.1, 1), z * random.between(0.1, 1)}};
  for (int axis = 0; axis < 3; ++axis) box.center[axis] = random.between(-1, 1);
  return box;
}

TEST(OrientedBoxTest, AreApartWhereTheirDistanceIsAboveZero) {
  int apart = 0;
  for (uint64_t i = 0; i < 2000; ++i) {
    Random random(1, i, "boxes");
    const OrientedBox a = anyBox(random), b = anyBox(random);
    const double distance = distanceBetween(a, b);
    if (distance > 1e-9 && distance < 1e-3) continue;  // slow to converge
    apart += distance > 1e-3;
    EXPECT_EQ(areApart(a, b, 0), distance > 1e-3) << i << " " << distance;
    EXPECT_TRUE(distance >= 0.2 - 1e-9 || !areApart(a, b, 0.2));
  }
  EXPECT_GT(apart, 300);
  EXPECT_LT(apart, 1700);
}

TEST(OrientedBoxTest, MayTouch) {
  const OrientedBox a{};
  EXPECT_TRUE(areApart(a, {.center = {2, 0, 0}}, 0));
  EXPECT_FALSE(areApart(a, {.center = {1.999, 1.999, 1.999}}, 0));
  EXPECT_FALSE(areApart(a, a, 0));
}

// The world-space box of an object's unit cube.
OrientedBox boxOf(const scene::Scene& scene, const scene::Instance& instance) {
  const scene::Mesh& mesh = scene.meshes[instance.mesh];
  OrientedBox box{.center = dvec3(mesh.boundsMin + mesh.boundsMax) * 0.5};
  for (int axis = 0; axis < 3; ++axis) box.half[axis] *= (mesh.boundsMax[axis] - mesh.boundsMin[axis]) * 0.5;
  return transformed(box, dmat4(instance.toWorld));
}

std::vector<OrientedBox> added(const scene::Scene& scene) {
  std::vector<OrientedBox> boxes;
  for (const scene::Instance& instance : scene.instances)
    if (!instance.removed && scene.nodes[instance.node].added > 0) boxes.push_back(boxOf(scene, instance));
  return boxes;
}

void expectApart(const std::vector<OrientedBox>& boxes, double gap) {
  for (size_t i = 0; i < boxes.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_GE(distanceBetween(boxes[i], boxes[j]), gap - 1e-5);
}

TEST(ScatterTest, PutsObjectsOnASurfaceApart) {
  Varied varied(R"([{"type": "scatter", "objects": [{"node": "matte"}, {"node": "metal"}], "count": 12, "on": "floor",
      "scale": [0.2, 0.5], "spacing": 0.1, "avoid": ["matte", "plastic", "metal", "glowing", "unlit", "wall"]}])");
  for (uint64_t n = 0; n < 10; ++n) {
    const Json said = varied.variations.apply(n)[0];
    const std::vector<OrientedBox> boxes = added(varied.scene);
    EXPECT_EQ(said["wanted"], 12);
    ASSERT_EQ(said["objects"].size(), boxes.size());
    EXPECT_GT(boxes.size(), 6u);
    expectApart(boxes, 0.1);
    for (const OrientedBox& box : boxes) {
      EXPECT_NEAR(box.center.z - extentAlong(box, {0, 0, 1}), 0, 1e-6);  // the top of the floor
      EXPECT_TRUE(std::abs(box.center.x) <= 12 && box.center.y >= -9 && box.center.y <= 6);
      for (const scene::BoxesBox& own : scene::boxesBoxes()) {
        if (own.name == "floor" || own.name == "mirrored") continue;
        const dvec3 low(own.min), high(own.max), center = (low + high) * 0.5, half = (high - low) * 0.5;
        const OrientedBox inWorld{.center = {center.x, -center.z, center.y},
                                  .half = {dvec3(half.x, 0, 0), dvec3(0, half.z, 0), dvec3(0, 0, half.y)}};
        EXPECT_GE(distanceBetween(box, inWorld), 0.1 - 1e-5);
      }
    }
  }
}

TEST(ScatterTest, KeepsToItsVolume) {
  Varied varied(R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": [3, 8], "min": [-3, 5, -3],
      "max": [3, 8, 3], "scale": [0.5, 1]}])");
  std::set<size_t> counts;
  for (uint64_t n = 0; n < 40; ++n) {
    varied.variations.apply(n);
    const std::vector<OrientedBox> boxes = added(varied.scene);
    counts.insert(boxes.size());
    expectApart(boxes, 0);
    for (const OrientedBox& box : boxes) {
      EXPECT_LE(std::abs(box.center.x) + extentAlong(box, {1, 0, 0}), 3 + 1e-5);
      EXPECT_LE(std::abs(box.center.y) + extentAlong(box, {0, 1, 0}), 3 + 1e-5);
      EXPECT_LE(std::abs(box.center.z - 6.5) + extentAlong(box, {0, 0, 1}), 1.5 + 1e-5);
    }
  }
  EXPECT_GE(counts.size(), 4u);
}

TEST(ScatterTest, SaysHowManyFoundNoPlace) {
  Varied varied(R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 50, "min": [0, 5, 0], "max": [2, 7, 2],
      "turn": 0, "tries": 10}])");
  const Json said = varied.variations.apply(1)[0];
  EXPECT_EQ(said["wanted"], 50);
  EXPECT_EQ(said["objects"].size(), 1u);  // a cube of 1.5 m in one of 2 m
}

// Pearson's statistic of shares in [0, 1) over ten equal bins, against the uniform distribution.
double chiSquared(const std::vector<double>& shares) {
  constexpr size_t kBins = 10;
  std::array<double, kBins> counts{};
  for (const double share : shares) ++counts[std::min(kBins - 1, static_cast<size_t>(share * kBins))];
  const double expected = static_cast<double>(shares.size()) / kBins;
  double sum = 0;
  for (const double count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

constexpr double kChiSquaredLimit = 27.88;  // exceeded with the probability 0.001 for nine degrees of freedom

// Returns the scales and the turns in degrees of an object that `spec` scatters. Each variation must place it.
std::pair<std::vector<double>, std::vector<double>> scalesAndTurns(const std::string& spec) {
  Varied varied(spec);
  std::pair<std::vector<double>, std::vector<double>> drawn;
  for (uint64_t n = 0; n < 1000; ++n) {
    const Json said = varied.variations.apply(n)[0];
    if (said["objects"].size() != 1) throw std::logic_error("an object was not placed");
    const Json& rows = said["objects"][0]["transform"];  // a rotation about Y in the file's frame, scaled
    const double cosine = rows[0][0], sine = rows[0][2];
    drawn.first.push_back(std::hypot(cosine, sine));
    drawn.second.push_back(glm::degrees(std::atan2(sine, cosine)));
  }
  return drawn;
}

// A cube of 1.5 m in a volume of 2 m. The center of the largest one has 614 times less space than that of the
// smallest one.
TEST(ScatterTest, ScalesAreUniformWhereLargeObjectsHardlyFit) {
  std::vector<double> shares = scalesAndTurns(R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 1,
      "min": [0, 5, 0], "max": [2, 7, 2], "turn": 0, "scale": [0.2, 1.2], "tries": 1000000}])")
                                   .first;
  for (double& share : shares) share -= 0.2;
  EXPECT_LT(chiSquared(shares), kChiSquaredLimit);
}

// A cube of 1.35 m is 1.91 m wide if it is turned by 45 degrees.
TEST(ScatterTest, TurnsAreUniformWhereTurnedObjectsHardlyFit) {
  std::vector<double> shares = scalesAndTurns(R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 1,
      "min": [0, 5, 0], "max": [2, 7, 2], "turn": [0, 45], "scale": 0.9, "tries": 1000000}])")
                                   .second;
  for (double& share : shares) share /= 45;
  EXPECT_LT(chiSquared(shares), kChiSquaredLimit);
}

TEST(ScatterTest, TakesWholeFilesAsOneObject) {
  Varied varied(R"([{"type": "scatter", "name": "plate", "objects": [{"file": "builtin:spheres"}], "count": 2,
      "on": "floor", "scale": 0.1}])");
  const Json said = varied.variations.apply(0)[0]["objects"];
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0]["node"], "/plate-0");
  std::map<uint32_t, int> parts;  // by id
  std::set<uint32_t> unique;
  for (const scene::Instance& instance : varied.scene.instances) {
    if (instance.removed || !varied.scene.nodes[instance.node].added) continue;
    ++parts[instance.id];
    EXPECT_TRUE(unique.insert(instance.part).second);
  }
  ASSERT_EQ(parts.size(), 2u);
  for (const auto& [id, count] : parts) EXPECT_EQ(count, int(scene::kSpheresColumns * scene::kSpheresRows));
  // "transform" samples positions in the file's frame, here those of its first sphere's center.
  const Json& rows = said[0]["transform"];
  const dvec3 center(scene::spheresCenter(0, 0));
  dvec3 placed;
  for (int row = 0; row < 3; ++row) {
    const Json& r = rows[static_cast<size_t>(row)];
    placed[row] = r[0].get<double>() * center.x + r[1].get<double>() * center.y + r[2].get<double>() * center.z +
                  r[3].get<double>();
  }
  double nearest = 1e9;
  for (const scene::Instance& instance : varied.scene.instances)
    if (!instance.removed && varied.scene.nodes[instance.node].path == "/plate-0")
      nearest =
          std::min(nearest, glm::length(boxOf(varied.scene, instance).center - dvec3(placed.x, -placed.z, placed.y)));
  EXPECT_LT(nearest, 1e-5);
}

// A copy has the frame of its original, which a negative scale mirrors from front to back.
TEST(ScatterTest, CopiesOfMirroredNodesHaveTheirFrames) {
  const Folder folder;
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 1};
  folder.write("m.bin", std::string_view(reinterpret_cast<const char*>(corners), sizeof(corners)));
  folder.write("m.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "m", "mesh": 0, "scale": [1, 1, -2]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "m.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                   "max": [1, 1, 1]}]})"));
  Varied varied(R"([{"type": "scatter", "objects": [{"node": "m"}], "count": 1, "min": [-9, -9, -9], "max": [9, 9, 9],
      "turn": 0, "scale": 0.5}])",
                folder.at("m.gltf"));
  varied.variations.apply(0);
  const scene::Scene& scene = varied.scene;
  ASSERT_EQ(scene.instances.size(), 2u);
  const std::vector<dmat4> toWorld = scene::instanceTransforms(scene, {});
  for (const uint32_t instance : {0u, 1u}) {
    const std::span<const uint32_t> object(&instance, 1);
    const scene::ObjectFrames frames(scene);
    const dmat4 frame =
        scene::toGltfFromWorld() * scene::rigidOf(frames.toWorld({}, toWorld, object), frames.scaleSigns(object));
    for (int axis = 0; axis < 3; ++axis) EXPECT_LE(glm::length(frame[axis] - dmat4(1)[axis]), 1e-6) << instance << axis;
  }
}

// A triangle at (3, 0, 0) with a point light 2 m above it, a spot light that shines along X, a disk, the sun, and a
// hidden lamp.
void writeLamp(const Folder& folder) {
  const float corners[] = {-0.5f, 0, -0.5f, 0.5f, 0, -0.5f, 0, 0, 0.5f};
  folder.write("lamp.bin", std::string_view(reinterpret_cast<const char*>(corners), sizeof(corners)));
  folder.write("lamp.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "extensionsUsed": ["KHR_lights_punctual", "KHR_node_visibility"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb", "intensity": 7},
      {"type": "spot", "name": "spot", "spot": {}}, {"type": "directional", "name": "sun"}]}},
    "nodes": [{"name": "lamp", "mesh": 0, "translation": [3, 0, 0], "children": [1, 2, 3, 4, 5]},
              {"translation": [0, 2, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"rotation": [0, -0.70710678, 0, 0.70710678], "extensions": {"KHR_lights_punctual": {"light": 1}}},
              {"extensions": {"KHR_lights_punctual": {"light": 2}}},
              {"extensions": {"KHR_node_visibility": {"visible": false}, "KHR_lights_punctual": {"light": 0}},
               "mesh": 0},
              {"extras": {"areaLight": {"type": "disk", "name": "disk", "intensity": 5, "size": 1}}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "lamp.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.5, 0, -0.5],
                   "max": [0.5, 0, 0.5]}]})"));
}

// Expects `count` copies of the lamp after the lights that the scene has by itself. Their place is that of their mesh,
// which is turned by 90 degrees about the world's Z, from X to Y, and scaled by 2.
void expectLampsLit(const scene::Scene& scene, size_t firstLight, size_t count) {
  std::vector<dvec3> places;
  for (const scene::Instance& instance : scene.instances)
    if (!instance.removed && scene.nodes[instance.node].added > 0) places.emplace_back(instance.toWorld[3]);
  std::map<std::string, std::vector<scene::Light>> lights;
  for (size_t i = firstLight; i < scene.lights.size(); ++i)
    if (!scene.lights[i].removed) lights[scene.lights[i].name].push_back(scene.lights[i]);
  ASSERT_EQ(places.size(), count);
  EXPECT_EQ(lights.size(), 3u);
  for (const char* name : {"bulb", "spot", "disk"}) ASSERT_EQ(lights[name].size(), count) << name;
  for (size_t i = 0; i < count; ++i) {
    EXPECT_LE(glm::length(lights["bulb"][i].position - (places[i] + dvec3(0, 0, 4))), 1e-5);
    EXPECT_EQ(lights["bulb"][i].intensity, 7);
    EXPECT_EQ(lights["bulb"][i].node, -1);
    EXPECT_LE(glm::length(lights["spot"][i].position - places[i]), 1e-5);
    EXPECT_LE(glm::length(lights["spot"][i].direction - glm::vec3(0, 1, 0)), 1e-5f);
    EXPECT_LE(glm::length(lights["disk"][i].axes[0] - glm::vec3(0, 2, 0)), 1e-5f);
  }
}

TEST(ScatterTest, CopiesHaveTheirLights) {
  const Folder folder;
  writeLamp(folder);
  const std::string source = folder.at("lamp.gltf"),
                    rest = R"(, "count": 2, "min": [-9, 5, -9], "max": [9, 9, 9], "turn": 90, "scale": 2}])";
  Varied file(R"([{"type": "scatter", "objects": [{"file": ")" + source + "\"}]" + rest);
  Varied node(R"([{"type": "scatter", "objects": [{"node": "lamp"}])" + rest, source);
  const size_t ownLights = file.scene.lights.size();
  for (uint64_t n = 0; n < 3; ++n) {
    file.variations.apply(n);
    expectLampsLit(file.scene, ownLights, 2);
    node.variations.apply(n);
    expectLampsLit(node.scene, 5, 2);
  }
}

// Returns the height in meters of a scattered tetrahedron that is 1 long along X, 2 along Y and 3 along Z.
double scatteredHeight(const std::string& keys, const scene::LoadOptions& load) {
  const Folder folder;
  folder.write("tall.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  scene::Scene scene = scene::load("builtin:boxes");
  Variations variations(Json::parse(R"([{"type": "scatter", "objects": [{"file": ")" + folder.at("tall.obj") + "\"" +
                                    keys + R"(}], "count": 1, "min": [-9, 0, -9], "max": [9, 9, 9]}])"),
                        scene, 1, load);
  variations.apply(0);
  double height = 0;
  for (const scene::Instance& instance : scene.instances) {
    if (instance.removed || scene.nodes[instance.node].added == 0) continue;
    double low = 1e9, high = -1e9;
    for (const glm::vec3& p : scene.meshes[instance.mesh].positions) {
      const double z = dvec3(instance.toWorld * dvec4(p, 1)).z;
      low = std::min(low, z), high = std::max(high, z);
    }
    height = high - low;
  }
  return height;
}

TEST(ScatterTest, FilesHaveTheJobsUnitAndAxesOrTheirOwn) {
  EXPECT_NEAR(scatteredHeight("", {}), 2, 1e-6);
  EXPECT_NEAR(scatteredHeight("", {.unit = "cm"}), 0.02, 1e-6);
  EXPECT_NEAR(scatteredHeight("", {.upAxis = "z"}), 3, 1e-6);
  EXPECT_NEAR(scatteredHeight(R"(, "unit": "ft")", {.unit = "cm"}), 0.6096, 1e-6);
  EXPECT_NEAR(scatteredHeight(R"(, "up-axis": "y")", {.unit = "cm", .upAxis = "z"}), 0.02, 1e-6);
}

// They define their unit and axes.
TEST(ScatterTest, BuiltInScenesIgnoreTheJobsUnit) {
  scene::Scene scene = scene::load("builtin:boxes");
  const Json spec = Json::parse(R"([{"type": "scatter", "objects": [{"file": "builtin:spheres"}], "count": 1,
                                     "on": "floor", "scale": 0.1}])");
  EXPECT_NO_THROW(Variations(spec, scene, 1, {.unit = "cm", .upAxis = "z", .pointRadius = 0.1f}));
}

TEST(ScatterTest, PointsHaveTheRadiusOfTheirFile) {
  const Folder folder;
  folder.write("points.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
               "end_header\n0 0 0\n");
  Json spec = Json::parse(R"([{"type": "scatter", "objects": [{"file": ")" + folder.at("points.ply") +
                          R"(", "point-radius": 0.5}], "count": 1, "min": [-9, 0, -9], "max": [9, 9, 9]}])");
  scene::Scene scene = scene::load("builtin:boxes");
  Variations variations(spec, scene, 1);
  const scene::Mesh& mesh = scene.meshes.back();
  EXPECT_NEAR(glm::length(mesh.positions.at(0)), 0.5, 0.01);
  EXPECT_EQ(variationFiles(spec, {}).size(), 1u);
}

}  // namespace
}  // namespace latelight::data::test
