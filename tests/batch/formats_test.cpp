// The batch renders the additional outputs that formats require.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "batch/sets.h"
#include "scene/builtin/builtin.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

TEST(FormatsOfABatch, CryptomatteAloneNamesTheObjects) {
  Folder folder;
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "cryptomatte", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  const auto matte = files.find("cryptomatte/000000.exr");
  ASSERT_NE(matte, files.end());
  EXPECT_THAT(matte->second, HasSubstr(R"("/boxes/plastic":")"));
}

TEST(FormatsOfABatch, BoxesAloneHaveObjects) {
  Folder folder;
  const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "boxes", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(filesOf(folder, "set")["boxes/000000.json"], HasSubstr(R"("node":"/boxes/plastic")"));
}

// The formats coco and transforms share the image, and transforms and depth-png share the depth.
TEST(FormatsOfABatch, SharedFilesAreRecordedOnce) {
  Folder folder;
  const app::Command command = batch(folder, {"--scenes", "builtin:boxes", "--formats", "coco", "--formats",
                                              "depth-png", "--formats", "transforms", "-o", "set"});
  ASSERT_EQ(latelight(command).code, 0);
  const auto before = filesOf(folder, "set");
  auto manifest = nlohmann::ordered_json::parse(before.at("manifest.json"));
  auto& files = manifest["frames"][0]["files"];
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file["file"]);
  EXPECT_THAT(names, testing::UnorderedElementsAre("images/000000.png", "depth/000000.png"));

  // Manifests of earlier versions have a record per format.
  for (auto* records : {&files, &manifest["files"]})
    for (const nlohmann::ordered_json copy = *records; const auto& file : copy) records->push_back(file);
  folder.write("set/manifest.json", manifest.dump());
  const auto verify = [&] { return latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}); };
  EXPECT_EQ(verify().code, 0);
  folder.write("set/images/000000.png", "damaged");
  folder.write("set/transforms.json", "damaged");
  const Outcome damaged = verify();
  EXPECT_EQ(damaged.code, 3);
  EXPECT_THAT(damaged.err, HasSubstr("2 files of 'set' differ from what was written"));
  for (const char* name : {"images/000000.png", "transforms.json"}) {
    const size_t at = damaged.err.find(name);
    ASSERT_NE(at, std::string::npos) << damaged.err;
    EXPECT_EQ(damaged.err.find(name, at + 1), std::string::npos) << damaged.err;
  }

  folder.write("set/images/000000.png", before.at("images/000000.png"));
  app::Command resume = command;
  resume.arguments.emplace_back("--resume");
  ASSERT_EQ(latelight(resume).code, 0);
  expectSame(filesOf(folder, "set"), before);
}

TEST(FormatsOfABatch, WhatHoldsCamerasIsReadAgainAsTheSameViews) {
  Folder folder;
  const char* orbit = R"({"type": "orbit", "count": 3, "distance": 4})";
  const Outcome outcome = latelight(
      batch(folder, {"--scenes", "builtin:boxes", "--cameras", orbit, "--formats", "bop", "--formats", "transforms",
                     "--formats", R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto set = filesOf(folder, "set");
  int sets = 0;
  for (const char* source : {R"({"type": "bop", "file": "set/train/000000/scene_camera.json", "size": [32, 24]})",
                             R"({"type": "transforms", "file": "set/transforms.json"})"}) {
    const std::string name = fmt::format("again{}", sets++);
    const Outcome again = latelight(batch(folder, {"--scenes", "builtin:boxes", "--cameras", source, "--formats",
                                                   R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", name}));
    ASSERT_EQ(again.code, 0) << again.text();
    auto same = filesOf(folder, name);
    std::erase_if(same, [](const auto& file) { return !file.first.starts_with("d/"); });
    EXPECT_EQ(same.size(), 3u);
    expectPartOf(same, set);
  }
}

// A scene and variation has files of its own, because its images differ from those of the others at the same cameras.
TEST(FormatsOfABatch, TransformsOfEachSceneAndVariation) {
  Folder folder;
  const auto render = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"--scenes",  "builtin:boxes",
                                       "--scenes",  "builtin:spheres",
                                       "--cameras", R"({"type": "orbit", "count": 2, "distance": 8})",
                                       "--formats", R"({"format": "transforms", "points": 4})",
                                       "--name",    "{scene}-{variation}-{camera}",
                                       "-o",        "set"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = latelight(batch(folder, arguments));
    EXPECT_EQ(outcome.code, 0) << outcome.text();
  };
  const auto expectSet = [&](int repeat) {
    const auto set = filesOf(folder, "set");
    std::set<std::string> files, expected;
    for (const auto& [name, contents] : set)
      if (name.find('/') == std::string::npos && name != "manifest.json") files.insert(name);
    std::set<std::string> images;
    for (int state = 0; state < 2 * repeat; ++state) {
      const std::string suffix = state == 0 ? "" : fmt::format("-{}", state);
      const std::string prefix = fmt::format("images/{}-{}-", state < repeat ? "boxes" : "spheres", state % repeat);
      const auto file = set.find("transforms" + suffix + ".json");
      ASSERT_NE(file, set.end()) << suffix;
      const auto json = nlohmann::json::parse(file->second);
      EXPECT_EQ(json["ply_file_path"], "sparse_pc" + suffix + ".ply");
      ASSERT_EQ(json["frames"].size(), 2u);
      for (const nlohmann::json& frame : json["frames"]) {
        const auto image = frame["file_path"].get<std::string>();
        EXPECT_THAT(image, testing::StartsWith(prefix));
        EXPECT_TRUE(images.insert(image).second && set.contains(image)) << image;
      }
      expected.insert({"transforms" + suffix + ".json", "sparse_pc" + suffix + ".ply"});
    }
    EXPECT_EQ(files, expected);
  };
  render({"--repeat", "2"});
  expectSet(2);
  render({"--repeat", "1", "--resume"});
  expectSet(1);
}

TEST(FormatsOfABatch, PatternsMayRepeatTheName) {
  Folder folder;
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats",
                               R"({"format": "files", "pattern": "{name}/{name}.png"})", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_TRUE(filesOf(folder, "set").contains("000000/000000.png"));
}

// One variation hides the floor, and others have objects that this one lacks.
TEST(FormatsOfABatch, NumbersAreThoseOfAllVariations) {
  Folder folder;
  folder.write("job.yaml", std::string_view(R"(
scenes: builtin:boxes
output: set
repeat: 6
cameras: {type: orbit, count: 1}
formats: [{format: scannet, categories: node}]
variations:
  - {type: visibility, nodes: floor, probability: 0.5}
  - {type: scatter, objects: [{node: metal}, {node: matte}], count: [0, 2], min: [-3, 1, -3], max: [3, 3, 3], name: a}
)"));
  const Outcome outcome = latelight(batch(folder, {"job.yaml"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  std::set<std::string> tables;
  for (const auto& [name, text] : files)
    if (name.ends_with("labels.tsv")) tables.insert(text);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_THAT(*tables.begin(),
              HasSubstr("id\traw_category\tcategory\n1\t/a-0\t/a-0\n2\t/a-1\t/a-1\n3\t/boxes/floor\t"));
  std::set<size_t> shown;
  const auto manifest = nlohmann::json::parse(files.at("manifest.json"));
  for (const auto& frame : manifest["frames"]) shown.insert(frame["drawn"][0]["visible"].size());
  EXPECT_EQ(shown, (std::set<size_t>{0, 1}));
}

// Runs a job with the formats coco and yolo, and expects these categories in both.
void expectCategories(const Folder& folder, const std::string& from, const std::string& job,
                      std::vector<std::string> options, const std::set<std::string>& names) {
  const std::string formats = "formats: [{{format: coco, categories: {0}}}, {{format: yolo, categories: {0}}}]\n";
  folder.write("job.yaml",
               fmt::format(fmt::runtime(formats), from) + "output: set\ncameras: {type: orbit, count: 1}\n" + job);
  options.insert(options.begin(), "job.yaml");
  const Outcome outcome = latelight(batch(folder, options));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  auto expected = nlohmann::json::array();
  std::string yolo = "names:\n";
  for (const std::string& name : names) {
    yolo += fmt::format("  {}: \"{}\"\n", expected.size(), name);
    expected.push_back({{"id", expected.size() + 1}, {"name", name}, {"supercategory", ""}});
  }
  EXPECT_EQ(nlohmann::json::parse(files.at("annotations/instances.json"))["categories"], expected);
  EXPECT_THAT(files.at("data.yaml"), testing::EndsWith(yolo));
}

// A training and a validation set have the same numbers, whatever their variations show.
TEST(FormatsOfABatch, CategoriesAreThoseOfTheScenes) {
  std::set<std::string> nodes;
  for (const scene::BoxesBox& box : scene::boxesBoxes()) nodes.insert(fmt::format("/boxes/{}", box.name));
  const std::string boxes = "scenes: builtin:boxes\n";
  const auto visible = [](int count) {
    return fmt::format("variations: [{{type: visibility, nodes: '*', visible: {}}}]\n", count);
  };
  for (const char* seed : {"7", "8"}) expectCategories(Folder(), "node", boxes + visible(2), {"--seed", seed}, nodes);
  const Folder folder;
  expectCategories(folder, "node", boxes + visible(0), {}, nodes);
  expectCategories(folder, "node", boxes + visible(0), {"--repeat", "2", "--resume"}, nodes);
  nodes.insert("/a-0");
  expectCategories(folder, "node", boxes + R"(
variations:
  - {type: visibility, nodes: "*", visible: 0}
  - {type: scatter, objects: [{node: matte}], count: [0, 1], min: [90, 90, 90], max: [95, 95, 95], name: a}
)",
                   {"--resume"}, nodes);
  expectCategories(Folder(), "mesh", "scenes: ['builtin:spheres', 'builtin:boxes']\n" + visible(0), {},
                   {"cube", "sphere"});
}

// Quotation marks as RFC 4180 defines them. Readers of tables end an unquoted field at the next one.
TEST(FormatsOfABatch, ScannetsLabelsAreQuoted) {
  Folder folder;
  const Outcome outcome = latelight(batch(
      folder, {"--scenes", "builtin:boxes", "--formats",
               R"({"format": "scannet", "categories": {"floor": "\"big\" floor", "matte": "a\tb", "metal": "c"}})",
               "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(folder.read("set/scans/scene0000_00/labels.tsv"),
            "id\traw_category\tcategory\n"
            "1\t\"\"\"big\"\" floor\"\t\"\"\"big\"\" floor\"\n"
            "2\ta b\ta b\n"
            "3\tc\tc\n");
}

// Each copy has a keypoint at its own center, 2 m from the next one.
TEST(FormatsOfABatch, KeypointsOfCopiesMoveWithThem) {
  Folder folder;
  const float values[] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0, 0.5f, 0, -2, 0, 0, 0, 0, 0, 2, 0, 0};
  folder.write("copies.bin", std::string_view(reinterpret_cast<const char*>(values), sizeof(values)));
  folder.write("copies.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "n", "mesh": 0, "children": [1],
               "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}},
              {"name": "tip", "translation": [0, 0.25, 0]}],
    "extensionsUsed": ["EXT_mesh_gpu_instancing"], "buffers": [{"uri": "copies.bin", "byteLength": 72}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.5, -0.5, 0],
      "max": [0.5, 0.5, 0]}, {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}]})"));
  const char* camera = R"({"type": "list", "cameras": [{"eye": [0, 0, 9], "target": [0, 0, 0]}]})";
  const char* boxes = R"({"format": "boxes", "keypoints": [{"name": "own"}, {"name": "below", "node": "tip"},
    {"name": "by path", "node": "/n"}]})";
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "copies.gltf", "--cameras", camera, "--formats", boxes, "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  std::map<std::string, double> expected{{"/n/instance0", -2}, {"/n/instance1", 0}, {"/n/instance2", 2}};
  const auto labels = nlohmann::json::parse(folder.read("set/boxes/000000.json"));
  ASSERT_EQ(labels["objects"].size(), 3u);
  for (const auto& object : labels["objects"])
    for (const auto& keypoint : object["keypoints"]) {
      const std::string node = object["node"];
      EXPECT_NEAR(keypoint["position"][0], expected.at(node), 1e-6) << node << keypoint["name"];
      EXPECT_NEAR(keypoint["position"][1], keypoint["name"] == "below" ? 0.25 : 0, 1e-6) << node << keypoint["name"];
      EXPECT_EQ(keypoint["visibility"], 2) << node << keypoint["name"];
    }
}

// A person with a hat, and a body that a hip moves by 1 m along X in 1 s. `rig`: the hip is below this node, which is
// the person or a root next to it.
std::string personFile(const std::string& rig) {
  const bool isOwn = rig == "person";
  return fmt::format(R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [{}]}}],
    "nodes": [{{"name": "person", "children": [{}]}}, {{"name": "body", "mesh": 0, "skin": 0}},
              {{"name": "hat", "mesh": 1, "translation": [0, 1, 0]}},
              {{"name": "hip", "translation": [0, 0.25, 0], "children": [4]}},
              {{"name": "tip", "translation": [0, 0.125, 0]}}, {{"name": "rig", "children": [{}]}}],
    "skins": [{{"joints": [3]}}],
    "animations": [{{"name": "walk", "samplers": [{{"input": 3, "output": 4}}],
      "channels": [{{"sampler": 0, "target": {{"node": 3, "path": "translation"}}}}]}}],
    "buffers": [{{"uri": "person.bin", "byteLength": 128}}],
    "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}}}]}},
               {{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
    "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 12}},
                    {{"buffer": 0, "byteOffset": 48, "byteLength": 48}},
                    {{"buffer": 0, "byteOffset": 96, "byteLength": 8}},
                    {{"buffer": 0, "byteOffset": 104, "byteLength": 24}}],
    "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.5, -0.5, 0],
                    "max": [0.5, 0.5, 0]}},
                  {{"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"}},
                  {{"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"}},
                  {{"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}},
                  {{"bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3"}}]}})",
                     isOwn ? "0" : "0, 5", isOwn ? "1, 2, 3" : "1, 2", isOwn ? "" : "3");
}

void writePerson(const Folder& folder, const std::string& rig) {
  const float corners[] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0, 0.5f, 0};
  const uint8_t joints[12] = {};
  const float weights[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, times[] = {0, 1}, hips[] = {0, 0.25f, 0, 1, 0.25f, 0};
  std::string bytes;
  const auto add = [&](const auto& values) { bytes.append(reinterpret_cast<const char*>(values), sizeof(values)); };
  add(corners), add(joints), add(weights), add(times), add(hips);
  folder.write("person.bin", std::string_view(bytes));
  std::string file = personFile(rig);
  if (const size_t empty = file.find(R"(, "children": [])"); empty != std::string::npos) file.erase(empty, 16);
  folder.write("person.gltf", std::string_view(file));
}

// Expects the keypoint of each object at the point of the original, mapped by the object's transform.
void expectKeypoints(const nlohmann::json& labels, const std::map<std::string, glm::dmat4>& transforms,
                     const std::map<std::string, glm::dvec3>& points) {
  EXPECT_EQ(labels["objects"].size(), transforms.size());
  for (const auto& object : labels["objects"]) {
    const std::string node = object["node"];
    ASSERT_TRUE(transforms.contains(node)) << node;
    ASSERT_EQ(object["keypoints"].size(), points.size()) << node;
    for (const auto& keypoint : object["keypoints"]) {
      const std::string name = keypoint["name"];
      const glm::dvec3 expected(transforms.at(node) * glm::dvec4(points.at(name), 1));
      ASSERT_TRUE(keypoint["position"].is_array()) << node << " " << name;
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(keypoint["position"][static_cast<size_t>(axis)], expected[axis], 1e-5) << node << " " << name;
    }
  }
}

// The transforms of objects that a frame's manifest states, and the identity for the original.
std::map<std::string, glm::dmat4> transformsOf(const nlohmann::json& scattered, const std::string& original) {
  std::map<std::string, glm::dmat4> transforms{{original, glm::dmat4(1)}};
  for (const auto& object : scattered["objects"]) {
    glm::dmat4& transform = transforms[object["node"].get<std::string>()];
    for (int i = 0; i < 16; ++i)
      transform[i % 4][i / 4] = object["transform"][static_cast<size_t>(i / 4)][static_cast<size_t>(i % 4)];
  }
  return transforms;
}

constexpr const char* kPeopleCamera =
    R"({"type": "list", "cameras": [{"eye": [0, 0, 15], "target": [0, 0, 0], "size": [320, 240]}]})";

// The skin of a copy moves with the joints, and all of its other parts are at rest.
TEST(FormatsOfABatch, KeypointsOfScatteredCopiesMoveWithThem) {
  Folder folder;
  writePerson(folder, "person");
  const char* scatter = R"([{"type": "scatter", "objects": [{"node": "person"}], "count": 3, "min": [-3, -3, -3],
    "max": [3, 3, 3], "turn": [-60, 60], "scale": [0.5, 1.5]}])";
  const char* boxes = R"({"format": "boxes", "keypoints": [{"name": "own", "position": [0.5, 0, 0]},
    {"name": "hip", "node": "hip"}, {"name": "tip", "node": "hip/tip"}, {"name": "hat", "node": "hat"},
    {"name": "path", "node": "/person/hip", "position": [0, 0, 0.5]}]})";
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "person.gltf", "--cameras", kPeopleCamera, "--variations", scatter,
                               "--id-depth", "0", "--formats", boxes, "--time", "0.5", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto manifest = nlohmann::json::parse(folder.read("set/manifest.json"));
  const auto transforms = transformsOf(manifest["frames"][0]["drawn"][0], "/person");
  EXPECT_EQ(transforms.size(), 4u);
  expectKeypoints(nlohmann::json::parse(folder.read("set/boxes/000000.json")), transforms,
                  {{"own", {0.5, 0, 0}},
                   {"hip", {0.5, 0.25, 0}},
                   {"tip", {0.5, 0.375, 0}},
                   {"hat", {0, 1, 0}},
                   {"path", {0.5, 0.25, 0.5}}});
}

// The joints of moved originals move with them, whether or not the scene has copies. "hip" is no joint of the hat.
TEST(FormatsOfABatch, KeypointsOfMovedNodesWithScatteredCopies) {
  Folder folder;
  writePerson(folder, "rig");
  const char* variations = R"([{"type": "transforms", "nodes": "NODE", "translation": [3, 2, 1]},
    {"type": "scatter", "objects": [{"node": "person"}], "count": 2, "min": [-3, -3, -3], "max": [3, 3, 0],
     "turn": [-60, 60]}])";
  const char* boxes = R"({"format": "boxes", "keypoints": [{"name": "hip", "node": "/rig/hip"}]})";
  for (const std::string node : {"person", "rig"}) {
    std::string moved(variations);
    moved.replace(moved.find("NODE"), 4, node);
    const Outcome outcome =
        latelight(batch(folder, {"--scenes", "person.gltf", "--cameras", kPeopleCamera, "--variations", moved,
                                 "--id-depth", "0", "--formats", boxes, "--time", "0.5", "-o", node}));
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    const auto manifest = nlohmann::json::parse(folder.read(node + "/manifest.json"));
    auto transforms = transformsOf(manifest["frames"][0]["drawn"][1], "/person");
    transforms["/person"][3] = {3, 2, 1, 1};
    expectKeypoints(nlohmann::json::parse(folder.read(node + "/boxes/000000.json")), transforms,
                    {{"hip", {0.5, 0.25, 0}}});
  }
}

// The object's frame has the rotation that its nodes state, without their scale, also if that mirrors. The mesh's
// center is (1, 2, 3), and the turned node's parent is mirrored from left to right.
TEST(FormatsOfABatch, FramesOfMirroredObjectsHaveTheRotationsOfTheirNodes) {
  Folder folder;
  const float corners[] = {0, 1, 2, 2, 1, 2, 1, 3, 4};
  folder.write("signs.bin", std::string_view(reinterpret_cast<const char*>(corners), sizeof(corners)));
  const std::vector<glm::dvec3> scales{{1, 1, 1}, {-1, 1, 1}, {1, -2, 1}, {1, 1, -1}, {-1, -1, 1}, {-3, -1, -1}};
  std::string nodes, roots;
  for (size_t i = 0; i < scales.size(); ++i) {
    const glm::dvec3& s = scales[i];
    nodes += fmt::format(R"({{"name": "n{}", "mesh": 0, "translation": [{}, 0, 0], "scale": [{}, {}, {}]}},)", i, 8 * i,
                         s.x, s.y, s.z);
    roots += fmt::format("{}, ", i);
  }
  folder.write("signs.gltf", std::string_view(fmt::format(R"({{"asset": {{"version": "2.0"}}, "scene": 0,
    "scenes": [{{"nodes": [{0}{1}]}}], "nodes": [{2} {{"name": "mirror", "scale": [-1, 1, 1], "children": [{3}]}},
      {{"name": "turned", "mesh": 0, "rotation": [0, 0.6, 0, 0.8]}}],
    "materials": [{{"doubleSided": true}}], "buffers": [{{"uri": "signs.bin", "byteLength": 36}}],
    "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
    "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
    "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 1, 2],
      "max": [2, 3, 4]}}]}})",
                                                          roots, scales.size(), nodes, scales.size() + 1)));
  const char* camera = R"({"type": "list", "cameras": [{"eye": [20, 0, 99], "target": [20, 0, 0],
    "size": [640, 480]}]})";
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "signs.gltf", "--cameras", camera, "--formats", "boxes", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto labels = nlohmann::json::parse(folder.read("set/boxes/000000.json"));
  ASSERT_EQ(labels["objects"].size(), scales.size() + 1);
  for (const auto& object : labels["objects"]) {
    const std::string node = object["node"];
    const bool isTurned = node == "/mirror/turned";
    const auto i = isTurned ? 1 : static_cast<size_t>(node.back() - '0');
    const glm::dvec3 center = scales[i] * glm::dvec3(1, 2, 3), size = 2.0 * glm::abs(scales[i]);
    // Half the angle has the sine 0.6: the angle the cosine 0.28 and the sine 0.96. The mirror turns it around.
    const glm::dmat3 rotation = isTurned ? glm::dmat3(0.28, 0, 0.96, 0, 1, 0, -0.96, 0, 0.28) : glm::dmat3(1);
    const glm::dvec3 position = rotation * center + glm::dvec3(isTurned ? 0.0 : 8.0 * double(i), 0, 0);
    const auto& box = object["box"];
    for (int row = 0; row < 3; ++row) {
      const auto r = static_cast<size_t>(row);
      for (int column = 0; column < 3; ++column)
        EXPECT_NEAR(box["toWorld"][r][static_cast<size_t>(column)], rotation[column][row], 1e-6) << node;
      EXPECT_NEAR(box["toWorld"][r][3], position[row], 1e-5) << node;
      EXPECT_NEAR(box["center"][r], center[row], 1e-5) << node;
      EXPECT_NEAR(box["size"][r], size[row], 1e-5) << node;
    }
  }
}

// "none" is the absence of an environment, as for --hdri.
TEST(VariationsOfABatch, MayDrawNoEnvironment) {
  Folder folder;
  const auto run = [&](const std::string& set, const std::vector<std::string>& environment) {
    std::vector<std::string> all{"--scenes", "builtin:boxes", "-o", set};
    all.insert(all.end(), environment.begin(), environment.end());
    const Outcome outcome = latelight(batch(folder, all));
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return folder.read(set + "/000000.png");
  };
  const std::string drawn = run("drawn", {"--variations", R"([{"type": "environments", "environments": "none"}])"});
  const std::string none = run("none", {"--hdri", "none"}), studio = run("studio", {"--hdri", "studio"});
  EXPECT_FALSE(drawn.empty());
  EXPECT_TRUE(drawn == none);
  EXPECT_FALSE(none == studio);
}

const std::vector<std::string> kArchives{"--scenes", "builtin:boxes", "--formats",
                                         R"({"format": "webdataset", "frames": 3})"};

Outcome archives(const Folder& folder, const std::string& set, std::vector<std::string> more) {
  std::vector<std::string> all = kArchives;
  all.insert(all.end(), {"-o", set});
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

// The plan knows the names of all files, so that none replaces another one.
TEST(FormatsOfABatch, FilesOfOneNameAreRejected) {
  Folder folder;
  const auto plan = [&](const std::vector<std::string>& formats, const std::vector<const char*>& cameras = {}) {
    std::string list;
    for (const char* name : cameras)
      list +=
          fmt::format(R"({}{{"name": "{}", "eye": [3, 1, 3], "target": [0, 1, 0]}})", list.empty() ? "" : ",", name);
    std::vector<std::string> all{"--scenes", "builtin:boxes", "-o", "set", "--dry-run"};
    for (const std::string& format : formats) all.insert(all.end(), {"--formats", format});
    if (!cameras.empty())
      all.insert(all.end(), {"--name", "{camera}", "--cameras", R"({"type": "list", "cameras": [)" + list + "]}"});
    return latelight(batch(folder, all));
  };
  const auto expectRejected = [](const Outcome& outcome, const char* sentence) {
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(sentence));
  };
  const char* files = R"({"format": "files", "outputs": ["color", "depth"]})";
  expectRejected(plan({R"({"format": "depth-png", "unit": "kitti"})", "transforms"}),
                 R"(depth-png (formats[0]) for the frame "000000" and transforms (formats[1]) for the frame "000000" )"
                 "would both write 'depth/000000.png'");
  expectRejected(plan({R"({"format": "exr", "outputs": ["color"]})", R"({"format": "exr", "outputs": ["depth"]})"}),
                 "would both write '000000.exr'");
  expectRejected(plan({"coco", R"({"format": "coco", "categories": "node"})"}),
                 "coco (formats[0]) and coco (formats[1]) would both write 'annotations/instances.json'");
  expectRejected(plan({R"({"format": "npz", "file": "train/000000/mask/{name}.npz"})", "bop"}),
                 "would both write 'train/000000/mask/'");
  expectRejected(plan({"bop", R"({"format": "npz", "file": "train/./000000//mask/{name}.npz"})"}),
                 "would both write 'train/000000/mask/000000.npz'");
  expectRejected(plan({files}, {"a", "a.depth"}), R"(files (formats[0]) for the frame "a" and files (formats[0]) for )"
                                                  R"(the frame "a.depth" would both write 'a.depth.png')");
  expectRejected(plan({"transforms", files}, {"transforms"}), "would both write 'transforms.json'");
  expectRejected(plan({files}, {"manifest"}), "would write 'manifest.json', which the data set itself reserves");
  expectRejected(plan({R"({"format": "exr", "file": ".latelight/{name}.exr"})"}), "the data set itself reserves");
  // Equal contents may have one name.
  for (const auto& formats : std::vector<std::vector<std::string>>{
           {"coco", "yolo", "voc", "colmap", R"({"format": "files", "pattern": "images/{name}.png"})"},
           {"depth-png", "transforms"},
           {"colmap", R"({"format": "colmap", "as": "text"})"},
           {"exr", "exr"}}) {
    const Outcome outcome = plan(formats);
    EXPECT_EQ(outcome.code, 0) << outcome.text();
  }
}

// Cameras that a format cannot express, and cameras that it cannot have in one set.
TEST(FormatsOfABatch, CamerasAreCheckedBeforeTheyAreRendered) {
  Folder folder;
  const auto plan = [&](const std::string& format, const std::string& cameras, std::vector<std::string> more = {}) {
    more.insert(more.end(), {"--scenes", "builtin:boxes", "-o", "set", "--formats", format, "--cameras", cameras});
    const size_t before = filesOf(folder, "set").size();
    std::vector<std::string> checked = more;
    checked.emplace_back("--dry-run");
    const Outcome dry = latelight(batch(folder, checked)), outcome = latelight(batch(folder, more));
    EXPECT_EQ(outcome.code, dry.code) << format << outcome.text() << dry.text();
    EXPECT_EQ(outcome.err, dry.err) << format;
    EXPECT_TRUE(outcome.code == 0 || filesOf(folder, "set").size() == before) << format;
    return outcome;
  };
  const auto expectRejected = [](const Outcome& outcome, const std::string& sentence) {
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(sentence));
  };
  folder.write("ortho.gltf", std::string_view(kOrthographicCamera));
  const auto listOf = [](const std::string& optics) {
    return R"({"type": "list", )" + optics + R"(, "cameras": [{"name": "a", "eye": [3, 1, 3], "target": [0, 1, 0]}]})";
  };
  const std::string bent = listOf(R"("K": [[30, 0, 16], [0, 30, 12], [0, 0, 1]], "size": [32, 24], )"
                                  R"("model": "opencv", "distortion": [0.1, 0, 0, 0, 0, 0.1])");
  for (const std::string format : {"hdf5", "kitti", "scannet", "bop"})
    expectRejected(plan(format, bent), "the format " + format + " cannot express cameras with a lens such as that of");
  expectRejected(plan("transforms", bent), "no k4, k5 and k6");
  for (const std::string format : {"hdf5", "kitti", "scannet", "bop", "colmap", "transforms"}) {
    const Outcome outcome =
        latelight(batch(folder, {"--scenes", "ortho.gltf", "-o", "set", "--formats", format, "--dry-run"}));
    expectRejected(outcome, "the format " + format + " cannot express orthographic cameras such as");
  }
  expectRejected(
      plan(R"({"format": "cryptomatte", "samples": 16})", R"({"type": "orbit", "count": 1, "size": [1025, 8]})"),
      "samples of the format cryptomatte: --size takes a width and a height from 1 to 16384 pixels");
  const std::string different =
      R"([{"type": "orbit", "count": 1, "fov": 40}, {"type": "orbit", "count": 1, "fov": 50}])";
  expectRejected(plan("scannet", different), "one camera matrix and size per scan");
  const std::string mixed =
      "[" + listOf(R"("fov": 50)") + ", " +
      listOf(
          R"("K": [[30, 0, 16], [0, 30, 12], [0, 0, 1]], "size": [32, 24], "model": "fisheye", "distortion": [0.1])") +
      "]";
  expectRejected(plan("transforms", mixed), "the format transforms has one camera_model for all frames");
  const std::string path = R"({"type": "path", "count": 3, "keys": [{"eye": [3, 1, 3], "target": [0, 1, 0]},
                                                                             {"eye": [4, 1, 3], "target": [0, 1, 0]}]})";
  expectRejected(plan("flow", path, {"--readout", "0.01"}), "--readout renders each row by itself");
  // Formats that an earlier run did not have check the cameras of its plan, too.
  EXPECT_EQ(plan("npz", different).code, 0);
  expectRejected(plan("scannet", different, {"--resume"}), "one camera matrix and size per scan");
}

// ffmpeg would stretch images of another size.
TEST(FormatsOfABatch, FilmsHaveImagesOfOneSize) {
  Folder folder;
  folder.write("ffmpeg", std::string_view("#!/bin/sh\n"));
  std::filesystem::permissions(folder.path() / "ffmpeg", std::filesystem::perms::owner_all);
  const auto plan = [&](const std::string& cameras) {
    app::Command command = batch(
        folder, {"--scenes", "builtin:boxes", "-o", "set", "--formats", "video", "--dry-run", "--cameras", cameras});
    command.environment["PATH"] = folder.path().string();
    return latelight(command);
  };
  const std::string large = R"({"type": "orbit", "count": 2, "size": [48, 24]})";
  const Outcome rejected = plan(R"([{"type": "scene"}, )" + large + "]");
  EXPECT_EQ(rejected.code, 2) << rejected.text();
  EXPECT_THAT(rejected.err, HasSubstr("the format video requires images of one size, but those of the cameras "));
  EXPECT_THAT(rejected.err, HasSubstr("have 32x24 and 48x24 pixels"));
  EXPECT_EQ(plan(large).code, 0);
}

void writeProgram(const Folder& folder, const std::string& name, std::string_view script) {
  folder.write(name, script);
  std::filesystem::permissions(folder.path() / name, std::filesystem::perms::owner_all);
}

// A terminal sends Ctrl-C to the process group of the batch, and others send signals to all processes.
TEST(FormatsOfABatch, ASignalStopsAFilm) {
  Folder folder;
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--scenes", "builtin:boxes", "-o", "set", "--repeat", "2", "--formats", "video"});
    app::Command command = batch(folder, more);
    command.environment["PATH"] = folder.path().string();
    return latelight(command);
  };
  // The fifth field is the process group.
  writeProgram(folder, "ffmpeg",
               "#!/bin/sh\n"
               "read -r _ _ _ _ own _ </proc/$$/stat\n"
               "read -r _ _ _ _ parent _ </proc/$PPID/stat\n"
               "[ $own = $parent ] && exit 1\n"
               "kill -INT $PPID\n"
               "exit 255\n");
  const Outcome stopped = run({});
  EXPECT_EQ(stopped.code, 6) << stopped.text();
  EXPECT_THAT(stopped.err, HasSubstr("stopped by SIGINT before 'set' was merged"));
  EXPECT_FALSE(filesOf(folder, "set").contains("video.mp4"));
  writeProgram(folder, "ffmpeg", "#!/bin/sh\n/bin/cat >/dev/null\necho encoded\n");
  const Outcome resumed = run({"--resume"});
  EXPECT_EQ(resumed.code, 0) << resumed.text();
  EXPECT_EQ(folder.read("set/video.mp4"), "encoded\n");
}

TEST(FormatsOfABatch, AMissingPieceOfAnArchiveIsNamed) {
  Folder folder;
  const auto run = [&](const char* part, const char* resume) {
    return latelight(batch(folder, {"--scenes", "builtin:boxes", "--repeat", "2", "--formats", "webdataset", "-o",
                                    "set", "--shard", part, resume}));
  };
  ASSERT_EQ(run("0/2", "--quiet").code, 0);
  ASSERT_TRUE(std::filesystem::remove(folder.path() / "set/shards/.frames/000000000.tar"));
  const Outcome outcome = run("1/2", "--quiet");
  EXPECT_EQ(outcome.code, 3) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr("'set/shards/.frames/000000000.tar' is missing: run the job with --resume"));
  EXPECT_EQ(run("0/2", "--resume").code, 0);
  EXPECT_EQ(latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}).code, 0);
}

// A video consists of images that the job writes.
TEST(FormatsOfABatch, FilmsHaveImages) {
  Folder folder;
  folder.write("ffmpeg", std::string_view("#!/bin/sh\n"));
  std::filesystem::permissions(folder.path() / "ffmpeg", std::filesystem::perms::owner_all);
  const auto plan = [&](const std::vector<std::string>& formats, bool dry = true) {
    std::vector<std::string> all{"--scenes", "builtin:boxes", "-o", "set"};
    for (const std::string& format : formats) all.insert(all.end(), {"--formats", format});
    if (dry) all.emplace_back("--dry-run");
    app::Command command = batch(folder, all);
    command.environment["PATH"] = folder.path().string();
    return latelight(command);
  };
  const auto video = [](const std::string& picture) {
    return R"({"format": "video", "write-pictures": false, "picture": ")" + picture + R"("})";
  };
  for (const auto& formats : std::vector<std::vector<std::string>>{
           {video("images/{name}.png")},
           {video("rgb/{name}.png"), "coco"},
           {R"({"format": "yolo", "write-pictures": false})", video("images/{name}.png")}}) {
    const Outcome outcome = plan(formats, false), dry = plan(formats);
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_EQ(dry.code, 2) << dry.text();
    EXPECT_THAT(outcome.err, HasSubstr("which no format of the job writes"));
    EXPECT_TRUE(filesOf(folder, "set").empty());
  }
  for (const auto& formats : std::vector<std::vector<std::string>>{
           {"video"},
           {video("images/{name}.png"), "coco"},
           {"files", video("./{name}.png")},
           {R"({"format": "depth-png", "unit": "kitti"})", video("depth/{name}.png")},
           {R"({"format": "yolo", "write-pictures": false})"}}) {  // its files only name the images
    const Outcome outcome = plan(formats);
    EXPECT_EQ(outcome.code, 0) << outcome.text();
  }
}

// COLMAP ends a name in images.txt at the first blank.
TEST(FormatsOfABatch, ColmapsTextHasNoNamesWithBlanks) {
  Folder folder;
  folder.write("my scene.gltf", std::string_view(kCameraAlone));
  const auto plan = [&](const char* format, const char* name) {
    return latelight(
        batch(folder, {"--scenes", "my scene.gltf", "-o", "set", "--dry-run", "--formats", format, "--name", name}));
  };
  const char* text = R"({"format": "colmap", "as": "text"})";
  const Outcome rejected = plan(text, "{scene}-{index}");
  EXPECT_EQ(rejected.code, 2);
  EXPECT_THAT(rejected.err,
              HasSubstr(R"(the format colmap cannot write the name "my scene-0.png", which has a blank)"));
  EXPECT_EQ(plan(text, "{index}").code, 0);
  EXPECT_EQ(plan(R"({"format": "colmap", "as": "text", "picture": "my images/{name}.png"})", "{index}").code, 0);
  EXPECT_EQ(plan("colmap", "{scene}").code, 0);
}

// Keys end at the first period, which the format replaces: two names may then be equal.
TEST(FormatsOfABatch, ArchivesHaveOneKeyPerFrame) {
  Folder folder;
  for (const char* name : {"a.b.gltf", "a_b.gltf"}) folder.write(name, std::string_view(kCameraAlone));
  const auto run = [&](const char* name) {
    return latelight(
        batch(folder, {"--scenes", "a?b.gltf", "--formats", "webdataset", "-o", "set", "--resume", "--name", name}));
  };
  const Outcome equal = run("{scene}");
  EXPECT_EQ(equal.code, 2) << equal.text();
  EXPECT_THAT(equal.err, HasSubstr(R"(the format webdataset stores the frames "a.b" and "a_b" as "a_b"; add {index})"));
  EXPECT_EQ(run("{scene}-{index}").code, 0);
}

// Frames are in archives only: their own files are removed, and none is rendered again.
TEST(FormatsOfABatch, ArchivesAreCompletedAndExtended) {
  Folder folder;
  ASSERT_EQ(archives(folder, "whole", {"--repeat", "7"}).code, 0);
  const auto whole = filesOf(folder, "whole");
  EXPECT_EQ(whole.size(), 3 + 1u);
  EXPECT_EQ(std::filesystem::exists(folder.path() / "whole/shards/.frames"), false);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "4"}).code, 0);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "7", "--resume"}).code, 0);
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("begins: 3 of 7 frames"));
  expectSame(filesOf(folder, "set"), whole);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "4", "--resume"}).code, 0);
  ASSERT_EQ(archives(folder, "four", {"--repeat", "4"}).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "four"));
}

TEST(FormatsOfABatch, ArchivesAreThoseOfOneProcessForAnyShards) {
  Folder folder;
  ASSERT_EQ(archives(folder, "whole", {"--repeat", "5"}).code, 0);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--shard", "1/2"}).code, 0);
  EXPECT_FALSE(filesOf(folder, "set").contains("shards/000000.tar"));
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--shard", "0/2"}).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "whole"));
}

TEST(FormatsOfABatch, DamagedArchivesAreFoundAndWrittenAgain) {
  Folder folder;
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5"}).code, 0);
  const auto before = filesOf(folder, "set");
  folder.write("set/shards/000000.tar", before.at("shards/000000.tar").substr(0, 3000));
  const Outcome verified = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
  EXPECT_EQ(verified.code, 3);
  EXPECT_THAT(verified.out + verified.err, HasSubstr("'shards/000000.tar' is not as it was written"));
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--resume"}).code, 0);
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("begins: 3 of 5 frames"));
  expectSame(filesOf(folder, "set"), before);
}

// An archive of the right size with other bytes is not used again, whether or not frames are added to it.
TEST(FormatsOfABatch, DamagedArchivesAreNotCompleted) {
  const std::string archive = "shards/000000.tar";
  for (const char* count : {"2", "3"}) {
    Folder folder;
    ASSERT_EQ(archives(folder, "whole", {"--repeat", count}).code, 0);
    ASSERT_EQ(archives(folder, "set", {"--repeat", "2"}).code, 0);
    std::string damaged = folder.read("set/" + archive);
    damaged.at(2000) ^= 1;
    folder.write("set/" + archive, std::string_view(damaged));
    const Outcome resumed = archives(folder, "set", {"--repeat", count, "--resume"});
    EXPECT_EQ(resumed.code, 3);
    EXPECT_THAT(resumed.err,
                HasSubstr("000000.tar' is not as it was written: remove it, and run the job with --resume"));
    const Outcome verified = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
    EXPECT_EQ(verified.code, 3);
    std::filesystem::remove(folder.path() / "set" / archive);
    ASSERT_EQ(archives(folder, "set", {"--repeat", count, "--resume"}).code, 0);
    expectSame(filesOf(folder, "set"), filesOf(folder, "whole"));
  }
}

}  // namespace
}  // namespace latelight::data
