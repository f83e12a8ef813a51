// Each kind of variation: its samples have the required distribution, and the scene matches its description.
#include <cmath>
#include <numbers>
#include <set>

#include "data/variations/temperature.h"
#include "data_variations/support.h"
#include "models/models.h"
#include "scene/load/load.h"
#include "shared/light.h"

namespace latelight::data::test {
namespace {

// Expects uniformly distributed values in [low, high]. Chi-square with nine degrees of freedom exceeds 27.88 once in
// 1000 times.
void expectUniform(const std::vector<double>& values, double low, double high) {
  std::vector<double> counts(10);
  for (const double value : values) {
    ASSERT_TRUE(value >= low && value <= high) << value;
    ++counts[std::min<size_t>(9, static_cast<size_t>((value - low) / (high - low) * 10))];
  }
  double chi = 0;
  const double expected = double(values.size()) / 10;
  for (const double count : counts) chi += (count - expected) * (count - expected) / expected;
  EXPECT_LT(chi, 27.88);
}

TEST(MaterialsTest, AreDrawnFromTheirRanges) {
  Varied varied(R"([{"type": "materials", "materials": ["matte", "pl*"], "roughness": [0.25, 0.75],
      "baseColor": [[0, 0.5, 1], [0.2, 0.5, 1]], "emissive": [[1, 0, 0], [2, 0, 0]]}])");
  const std::vector<scene::Material> before = varied.scene.materials;
  std::vector<double> rough, red, emitted;
  for (uint64_t n = 0; n < 500; ++n) {
    const Json said = varied.variations.apply(n);
    for (size_t i = 0; i < before.size(); ++i) {
      const scene::Material& material = varied.scene.materials[i];
      const bool chosen = material.name == "matte" || material.name == "plastic";
      EXPECT_EQ(material.data.metallic, before[i].data.metallic);
      EXPECT_EQ(material.data.id, before[i].data.id);
      if (!chosen) {
        EXPECT_EQ(material.data.roughness, before[i].data.roughness);
        continue;
      }
      rough.push_back(material.data.roughness), red.push_back(material.data.baseColor.r);
      emitted.push_back(material.data.emissive.r);
      EXPECT_EQ(material.data.baseColor.g, 0.5f);
      EXPECT_EQ(material.data.baseColor.b, 1.0f);
    }
    ASSERT_EQ(said[0]["materials"].size(), 2u);
    EXPECT_EQ(said[0]["materials"][0]["name"], "matte");
    EXPECT_EQ(said[0]["materials"][0]["roughness"].get<float>(), rough[rough.size() - 2]);
  }
  expectUniform(rough, 0.25, 0.75);
  expectUniform(red, 0, 0.2);
  expectUniform(emitted, 1, 2);
}

// Computed with another implementation of Philox and FNV-1a. The samples of a seed must never change.
TEST(MaterialsTest, AreTheSameOnEveryMachine) {
  Varied varied(R"([{"type": "materials", "materials": "matte", "roughness": [0.25, 0.75]}])");
  ASSERT_EQ(varied.scene.materials[2].name, "matte");
  const float expected[] = {0.7062232494354248f, 0.3482992947101593f, 0.7184122800827026f};
  for (uint64_t n = 0; n < 3; ++n) {
    varied.variations.apply(n);
    EXPECT_EQ(varied.scene.materials[2].data.roughness, expected[n]);
  }
}

TEST(TexturesTest, AreSwapped) {
  const Folder folder;
  folder.write("b.BMP", bitmap(0, 0, 255));
  folder.write("a.bmp", bitmap(255, 0, 0));
  folder.write("notes.txt", "no picture");
  Varied varied(R"([{"type": "textures", "materials": "matte", "repeat": [2, 3], "folder": ")" +
                folder.path().string() + "\"}]");
  ASSERT_EQ(varied.scene.textures.size(), 2u);
  EXPECT_TRUE(varied.scene.textures[0].srgb);
  EXPECT_EQ(varied.scene.textures[0].pixels[0], std::byte{255});  // a.bmp is red
  std::array<int, 2> used{};
  std::vector<double> repeats;
  for (uint64_t n = 0; n < 400; ++n) {
    const Json said = varied.variations.apply(n)[0]["materials"][0];
    const scene::Material& material = varied.scene.materials[2];
    const int texture = material.slots[shared::kTextureBaseColor].texture;
    ASSERT_TRUE(texture == 0 || texture == 1);
    EXPECT_EQ(said["texture"], folder.at(texture == 0 ? "a.bmp" : "b.BMP"));
    EXPECT_EQ(material.data.textures & 1u, 1u);
    ++used[static_cast<size_t>(texture)];
    const shared::TextureTransform& transform = material.data.transforms[shared::kTextureBaseColor];
    EXPECT_EQ(transform.row0.x, transform.row1.y);
    repeats.push_back(transform.row0.x);
    EXPECT_EQ(said["repeat"].get<float>(), transform.row0.x);
  }
  EXPECT_LT(std::abs(used[0] - 200), 35);  // 3.5 standard deviations
  expectUniform(repeats, 2, 3);
}

// A card in the plane of x and y whose texture coordinates are its positions.
TEST(TexturesTest, NormalMapsHaveTangents) {
  const Folder folder;
  folder.write("n.bmp", bitmap(216, 128, 217));
  folder.write("card.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  const std::string scatter = R"({"type": "scatter", "objects": [{"file": ")" + folder.at("card.obj") +
                              R"("}], "count": 1, "min": [-9, 0, -9], "max": [9, 9, 9]})";
  const std::string textures =
      R"({"type": "textures", "materials": "*", "slot": "normal", "files": [")" + folder.at("n.bmp") + "\"]}";
  EXPECT_FALSE(addsNormalMaps(Json::parse("[" + scatter + "]")));
  const std::string spec = "[" + scatter + ", " + textures + "]";
  EXPECT_TRUE(addsNormalMaps(Json::parse(spec)));
  const Varied plain("[" + scatter + "]"), varied(spec);
  EXPECT_EQ(plain.scene.meshes.back().attributes.at(0).tangent, glm::vec4(0));
  EXPECT_EQ(varied.scene.meshes.back().attributes.at(0).tangent, glm::vec4(1, 0, 0, 1));
}

TEST(LightsTest, AreChanged) {
  Varied varied(
      R"([{"type": "lights", "intensity": [0.5, 2], "jitter": 0.25, "temperature": [2000, 9000], "on": [3, 5]}])",
      "builtin:hall,triangles=50k,lights=8");
  const std::vector<scene::Light> before = varied.scene.lights;
  std::vector<double> factors, moves;
  std::set<size_t> ons;
  for (uint64_t n = 0; n < 200; ++n) {
    const Json said = varied.variations.apply(n)[0]["lights"];
    ASSERT_EQ(said.size(), before.size());
    size_t on = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      const scene::Light& light = varied.scene.lights[i];
      on += light.intensity > 0;
      EXPECT_EQ(said[i]["intensity"].get<float>(), light.intensity);
      moves.push_back(light.position.x - before[i].position.x);
      if (light.intensity > 0) factors.push_back(light.intensity / before[i].intensity);
      const dvec3 expected = colorOfTemperature(said[i]["temperature"].get<float>());
      EXPECT_NEAR(light.color.r, expected.r, 1e-6);
      EXPECT_EQ(light.node, -1);
    }
    ons.insert(on);
  }
  EXPECT_THAT(ons, testing::ElementsAre(3u, 4u, 5u));
  expectUniform(factors, 0.5 - 1e-6, 2 + 1e-6);
  expectUniform(moves, -0.25 - 1e-5, 0.25 + 1e-5);
}

// Wyszecki and Stiles, "Color Science", table 1(3.11): chromaticities of full radiators.
TEST(TemperatureTest, IsThatOfFullRadiators) {
  struct Radiator {
    double kelvin, x, y;
  };
  for (const Radiator r :
       {Radiator{2000, 0.5267, 0.4133}, Radiator{2856, 0.4475, 0.4075}, Radiator{4000, 0.3805, 0.3768},
        Radiator{5000, 0.3451, 0.3516}, Radiator{6500, 0.3135, 0.3237}, Radiator{10000, 0.2807, 0.2884}}) {
    const dvec3 c = colorOfTemperature(r.kelvin);
    const double x = 0.4124564 * c.r + 0.3575761 * c.g + 0.1804375 * c.b;
    const double y = 0.2126729 * c.r + 0.7151522 * c.g + 0.0721750 * c.b;
    const double z = 0.0193339 * c.r + 0.1191920 * c.g + 0.9503041 * c.b;
    EXPECT_NEAR(y, 1, 1e-6);
    EXPECT_NEAR(x / (x + y + z), r.x, 2e-3) << r.kelvin;
    EXPECT_NEAR(y / (x + y + z), r.y, 2e-3) << r.kelvin;
  }
}

TEST(AddedLightsTest, AreWhereTheyMayBe) {
  Varied varied(R"([{"type": "addedLights", "count": [0, 6], "light": "spot", "min": [-1, 2, -3], "max": [1, 4, 3],
      "intensity": [5, 10], "tilt": 60, "range": 7, "castShadow": true}])");
  const size_t own = varied.scene.lights.size();
  std::set<size_t> counts;
  std::vector<double> heights, cosines;
  for (uint64_t n = 0; n < 200; ++n) {
    const Json said = varied.variations.apply(n)[0]["lights"];
    size_t present = 0;
    for (size_t i = own; i < varied.scene.lights.size(); ++i) {
      const scene::Light& light = varied.scene.lights[i];
      if (light.removed) continue;
      const Json& one = said[present++];
      EXPECT_EQ(light.type, shared::kLightSpot);
      EXPECT_EQ(light.range, 7);
      EXPECT_EQ(light.castShadow, true);
      EXPECT_EQ(one["intensity"].get<float>(), light.intensity);
      heights.push_back(light.position.z);  // the world's Z is the file's Y
      EXPECT_EQ(one["position"][1].get<double>(), light.position.z);
      EXPECT_NEAR(one["direction"][1].get<float>(), light.direction.z, 1e-6);
      EXPECT_NEAR(glm::length(light.direction), 1, 1e-6);
      cosines.push_back(-light.direction.z);
    }
    EXPECT_EQ(said.size(), present);
    counts.insert(present);
  }
  EXPECT_EQ(counts.size(), 7u);
  EXPECT_EQ(*counts.rbegin(), 6u);
  expectUniform(heights, 2, 4);
  expectUniform(cosines, 0.5 - 1e-6, 1 + 1e-6);  // uniform over the cap: equal steps of height have equal areas
}

TEST(EnvironmentsTest, AreDrawn) {
  Varied varied(R"([{"type": "environments", "environments": ["studio", "none"], "rotation": [-90, 90]}])");
  int studios = 0;
  std::vector<double> rotations;
  for (uint64_t n = 0; n < 400; ++n) {
    const Json said = varied.variations.apply(n)[0];
    EXPECT_EQ(said["environment"], varied.variations.environment());
    EXPECT_EQ(said["rotation"], varied.variations.environmentRotation().value());
    rotations.push_back(said["rotation"]);
    studios += varied.variations.environment() == "studio";
  }
  EXPECT_LT(std::abs(studios - 200), 35);
  expectUniform(rotations, -90, 90);
  Varied plain("[]");
  plain.variations.apply(0);
  EXPECT_EQ(plain.variations.environment(), "");
  EXPECT_FALSE(plain.variations.environmentRotation());
}

uint32_t instanceAt(const scene::Scene& scene, const std::string& path) {
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (scene.nodes[scene.instances[i].node].path == path) return i;
  return ~0u;
}

TEST(TransformsTest, MoveNodesAboutTheirOrigins) {
  Varied varied(R"([{"type": "transforms", "nodes": "matte", "translation": [[0, 0, 0], [0, 1, 0]], "rotation": [0, 90],
      "scale": [0.5, 2]}])");
  const uint32_t index = instanceAt(varied.scene, "/boxes/matte"), other = instanceAt(varied.scene, "/boxes/metal");
  const dmat4 toFile(scene::toGltfFromWorld()), before = toFile * dmat4(varied.scene.instances[index].toWorld);
  const glm::dmat4 untouched = varied.scene.instances[other].toWorld;
  std::vector<double> turns, lifts, scales;
  for (uint64_t n = 0; n < 300; ++n) {
    const Json said = varied.variations.apply(n)[0]["nodes"][0];
    const double turn = said["rotation"].get<double>() * std::numbers::pi / 180, scale = said["scale"];
    const double lift = said["translation"][1];
    turns.push_back(said["rotation"]), lifts.push_back(lift), scales.push_back(scale);
    EXPECT_EQ(said["node"], "/boxes/matte");
    const dmat4 after = toFile * dmat4(varied.scene.instances[index].toWorld);
    // About the file's up, Y, through the node's origin.
    const dvec3 origin(before[3]);
    for (const dvec4 p : {dvec4(0, 0, 0, 1), dvec4(0.5, 0.5, -0.5, 1)}) {
      const dvec3 from = dvec3(before * p) - origin;
      const dvec3 turned(std::cos(turn) * from.x + std::sin(turn) * from.z, from.y,
                         -std::sin(turn) * from.x + std::cos(turn) * from.z);
      EXPECT_LE(glm::length(dvec3(after * p) - (origin + dvec3(0, lift, 0) + scale * turned)), 2e-6);
    }
    EXPECT_EQ(varied.scene.instances[other].toWorld, untouched);
  }
  expectUniform(turns, 0, 90);
  expectUniform(lifts, 0, 1);
  expectUniform(scales, 0.5, 2);
}

// At 100,000 km a float is 8 m wide.
TEST(TransformsTest, MoveAndTakeBackExactlyFarFromTheOrigin) {
  scene::Scene scene = scene::load("builtin:boxes");
  const uint32_t index = instanceAt(scene, "/boxes/matte");
  scene.instances[index].toWorld[3] += dvec4(1e8 + 0.25, 0.5, 0, 0);
  const dvec3 before(scene.instances[index].toWorld[3]);
  {
    Variations variations(
        Json::parse(R"([{"type": "transforms", "nodes": "matte", "translation": [[0.5, 0, 0], [0.5, 0, 0]]}])"), scene,
        1);
    for (uint64_t n = 0; n < 3; ++n) {
      variations.apply(n);
      EXPECT_LE(glm::length(dvec3(scene.instances[index].toWorld[3]) - before - dvec3(0.5, 0, 0)), 5e-8) << n;
    }
  }
}

// A node at (1, 2, 3) above two others, one of which has a spot light.
constexpr const char* kLampFile = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "name": "bulb", "spot": {}}]}},
    "nodes": [{"name": "lamp", "translation": [1, 2, 3], "children": [1, 2]},
              {"name": "socket", "translation": [0, 0, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"name": "foot", "translation": [0, -1, 1]}]})";

// The scene of kLampFile in its first variation.
struct VariedLamp {
  explicit VariedLamp(const std::string& entries) {
    const Folder folder;
    folder.write("lamp.gltf", std::string_view(kLampFile));
    scene = scene::load(folder.at("lamp.gltf"));
    variations.emplace(Json::parse("[" + entries + "]"), scene, 1);
    variations->apply(0);
  }
  // The transform of a node to the file's frame.
  dmat4 toFile(const std::string& node) const {
    for (uint32_t i = 0; i < scene.nodes.size(); ++i)
      if (scene.nodes[i].name == node) return scene::toGltfFromWorld() * variations->movedNodes().at(i);
    throw std::out_of_range(node);
  }
  dvec3 lightInFile() const { return scene::toGltfFromWorld() * dvec4(scene.lights.at(0).position, 1); }
  scene::Scene scene;
  std::optional<Variations> variations;
};

void expectNear(const dvec3& a, const dvec3& b) {
  EXPECT_LE(glm::length(a - b), 1e-6) << a.x << " " << a.y << " " << a.z;
}

const std::string kMoveLamp = R"({"type": "transforms", "nodes": "lamp", "translation": [5, 0, 0]})";

// A quarter turn about Y leads from Z to X.
TEST(TransformsTest, MoveTheLightsOfNodes) {
  const VariedLamp lamp(R"({"type": "transforms", "nodes": "lamp", "translation": [5, 0, 0], "rotation": 90})");
  expectNear(lamp.lightInFile(), {8, 2, 3});
  expectNear(dvec3(scene::toGltfFromWorld() * dvec4(lamp.scene.lights[0].direction, 0)), {-1, 0, 0});
  const VariedLamp socket(R"({"type": "transforms", "nodes": "socket", "translation": [0, 7, 0]})");
  expectNear(socket.lightInFile(), {1, 9, 5});
}

TEST(TransformsTest, LeaveLightsThatJitterHasMoved) {
  const std::string jitter = R"({"type": "lights", "jitter": 0})";
  expectNear(VariedLamp(jitter + "," + kMoveLamp).lightInFile(), {1, 2, 5});
  expectNear(VariedLamp(kMoveLamp + "," + jitter).lightInFile(), {6, 2, 5});
}

TEST(TransformsTest, MoveTheLightsOfNodesAfresh) {
  VariedLamp lamp(R"({"type": "transforms", "nodes": "lamp", "translation": [[0, 0, 0], [9, 0, 0]]})");
  for (uint64_t n = 0; n < 3; ++n) {
    const Json said = lamp.variations->apply(n)[0]["nodes"][0]["translation"];
    expectNear(lamp.lightInFile(), {1 + said[0].get<double>(), 2, 5});
  }
}

// Each entry turns and scales a node about the origin to which the entries before have moved it.
TEST(TransformsTest, ApplyInOrder) {
  const VariedLamp turned(kMoveLamp + R"(, {"type": "transforms", "nodes": "lamp", "rotation": 90})");
  expectNear(turned.toFile("lamp")[3], {6, 2, 3});
  expectNear(turned.toFile("foot")[3], {7, 1, 3});
  expectNear(turned.lightInFile(), {8, 2, 3});
  const VariedLamp scaled(kMoveLamp + R"(, {"type": "transforms", "nodes": "lamp", "scale": 2})");
  expectNear(scaled.toFile("lamp")[3], {6, 2, 3});
  expectNear(scaled.toFile("foot")[3], {6, 0, 5});
  expectNear(scaled.lightInFile(), {6, 2, 7});
  const VariedLamp footTurned(kMoveLamp + R"(, {"type": "transforms", "nodes": "foot", "rotation": 90})");
  expectNear(footTurned.toFile("foot")[3], {6, 1, 4});
  expectNear(footTurned.toFile("foot")[2], {1, 0, 0});
}

// The mesh is next to the topmost joint, not below it.
TEST(TransformsTest, MoveSkinsWithTheirJoints) {
  const std::string model = models::modelPath("skinned.glb").string();
  const scene::Scene rest = scene::load(model);
  const auto skinned =
      static_cast<uint32_t>(std::ranges::find_if(rest.instances, &scene::Instance::posed) - rest.instances.begin());
  ASSERT_LT(skinned, rest.instances.size());
  const scene::Skin& skin = rest.rig.skins.at(0);
  std::vector<std::string> joints;
  for (size_t i = 0; i < rest.rig.sceneNodes.size(); ++i)
    if (std::ranges::find(skin.joints, rest.rig.sceneNodes[i]) != skin.joints.end())
      joints.push_back(rest.nodes[i].path);
  const auto spec = [](const std::string& node) {
    return R"([{"type": "transforms", "nodes": ")" + node + R"(", "translation": [5, 0, 0]}])";
  };
  Varied varied(spec(joints.front()), model);
  varied.variations.apply(0);
  const dmat4 before(rest.instances[skinned].toWorld), after(varied.scene.instances[skinned].toWorld);
  expectNear(dvec3(after[3] - before[3]), {5, 0, 0});
  try {
    Varied bent(spec(joints.back()), model);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_THAT(error.what(), testing::StartsWith("variations[0].nodes: " + joints.back() + " moves only some joints"));
  }
}

TEST(LightsTest, StateTheirPositionsAsDoubles) {
  scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=8");
  for (scene::Light& light : scene.lights) light.position.x += 1e8 + 0.3;
  Variations variations(Json::parse(R"([{"type": "lights", "jitter": 0.25}])"), scene, 1);
  const Json said = variations.apply(0)[0]["lights"];
  for (size_t i = 0; i < scene.lights.size(); ++i)
    EXPECT_EQ(said[i]["position"][0].get<double>(), scene.lights[i].position.x) << i;
}

// Like all positions that a set states, these are in the frame of the scene's file, where Y points up in glTF.
TEST(LightsTest, StateTheirPositionsInTheFilesFrame) {
  scene::Scene scene = scene::load(models::modelPath("punctual.glb").string());
  ASSERT_TRUE(scene.yUp);
  Variations variations(Json::parse(R"([{"type": "lights", "jitter": 0.25}])"), scene, 1);
  const Json said = variations.apply(0)[0]["lights"];
  ASSERT_GT(scene.lights.size(), 1u);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const glm::dvec3 p = scene.lights[i].position;
    const Json expected = {p.x, p.z, -p.y};
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(said[i]["position"][axis].get<double>(), expected[axis].get<double>(), 1e-12) << i;
  }
}

TEST(VisibilityTest, IsByChance) {
  Varied varied(R"([{"type": "visibility", "nodes": ["matte", "metal"], "probability": 0.25}])");
  const uint32_t matte = instanceAt(varied.scene, "/boxes/matte"), metal = instanceAt(varied.scene, "/boxes/metal");
  std::array<int, 4> cases{};
  for (uint64_t n = 0; n < 800; ++n) {
    const Json said = varied.variations.apply(n)[0]["visible"];
    const bool a = !varied.scene.instances[matte].removed, b = !varied.scene.instances[metal].removed;
    ++cases[static_cast<size_t>(a) + 2 * b];
    EXPECT_EQ(said.size(), static_cast<size_t>(a) + b);
    EXPECT_EQ(a, !said.empty() && said[0] == "/boxes/matte");
  }
  // The choices are independent of each other. Chi-square with three degrees of freedom exceeds 16.27 once in 1000
  // times.
  const double expected[] = {450, 150, 150, 50};
  double chi = 0;
  for (size_t i = 0; i < 4; ++i) chi += (cases[i] - expected[i]) * (cases[i] - expected[i]) / expected[i];
  EXPECT_LT(chi, 16.27);
}

TEST(VisibilityTest, LeavesExactlySoMany) {
  Varied varied(R"([{"type": "visibility", "nodes": "/boxes/*", "visible": 3}])");
  std::map<std::string, int> seen;
  for (uint64_t n = 0; n < 400; ++n) {
    const Json said = varied.variations.apply(n)[0]["visible"];
    EXPECT_EQ(said.size(), 3u);
    std::set<std::string> there;
    for (const scene::Instance& instance : varied.scene.instances)
      if (!instance.removed) there.insert(varied.scene.nodes[instance.node].path);
    EXPECT_EQ(there.size(), 3u);
    for (const Json& path : said) {
      EXPECT_TRUE(there.contains(path.get<std::string>()));
      ++seen[path.get<std::string>()];
    }
  }
  EXPECT_EQ(seen.size(), 8u);
  for (const auto& [path, times] : seen) EXPECT_NEAR(times, 150, 35) << path;  // 3.6 standard deviations
}

// Returns the paths of the nodes that are rendered in the first variation.
std::set<std::string> shownNodes(const std::string& entries, Json& record) {
  Varied varied("[" + entries + "]");
  record = varied.variations.apply(0);
  std::set<std::string> shown;
  for (const scene::Instance& instance : varied.scene.instances)
    if (!instance.removed) shown.insert(varied.scene.nodes[instance.node].path);
  return shown;
}

// The last entry that selects a node decides; a node is rendered if all nodes above it are visible, too.
TEST(VisibilityTest, IsThatOfTheLastEntry) {
  const std::string hideAll = R"({"type": "visibility", "nodes": "/boxes/*", "visible": 0})",
                    showMatte = R"({"type": "visibility", "nodes": "matte", "visible": 1})",
                    hideMatte = R"({"type": "visibility", "nodes": "matte", "visible": 0})",
                    hideRoot = R"({"type": "visibility", "nodes": "/boxes", "visible": 0})";
  Json record;
  EXPECT_THAT(shownNodes(hideAll + "," + showMatte, record), testing::ElementsAre("/boxes/matte"));
  EXPECT_EQ(record[1]["visible"], Json({"/boxes/matte"}));
  EXPECT_TRUE(shownNodes(showMatte + "," + hideAll, record).empty());
  EXPECT_EQ(shownNodes(hideMatte, record).size(), 7u);
  EXPECT_TRUE(shownNodes(hideRoot + "," + showMatte, record).empty());
}

}  // namespace
}  // namespace latelight::data::test
