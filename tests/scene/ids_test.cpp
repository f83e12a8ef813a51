// Ids of nodes, parts, copies and materials, and groups of them.
#include "scene/ids.h"

#include <gmock/gmock.h>

#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "gltf_builder.h"
#include "scene/load/load.h"

namespace latelight::scene::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Car > (Wheel > Rim, Wheel, Door), Road; all except Car have the mesh with two primitives.
GltfBuilder carFile() {
  GltfBuilder b = triangleFile();
  b.root["meshes"][0]["name"] = "Thing";
  json second = b.primitive();
  second["material"] = b.add("materials", {{"name", "second"}});
  b.root["meshes"][0]["primitives"].push_back(second);
  b.root["nodes"] = {{{"name", "Car"}, {"children", {1, 2, 3}}},
                     {{"name", "Wheel"}, {"mesh", 0}, {"children", {4}}},
                     {{"name", "Wheel"}, {"mesh", 0}},
                     {{"name", "Door"}, {"mesh", 0}},
                     {{"name", "Rim"}, {"mesh", 0}},
                     {{"name", "Road"}, {"mesh", 0}}};
  b.root["scenes"][0]["nodes"] = {0, 5};
  return b;
}

// For each node, the path whose hash is the id of its instances.
std::map<std::string, std::string> idsOf(const Scene& scene) {
  std::map<uint32_t, std::string> paths;
  for (const Node& node : scene.nodes) paths[hash32(node.path)] = node.path;
  std::map<std::string, std::string> ids;
  for (const Instance& instance : scene.instances) {
    EXPECT_EQ(instance.id, scene.nodes[instance.node].id) << scene.nodes[instance.node].path;
    ids[scene.nodes[instance.node].path] = paths[instance.id];
  }
  return ids;
}

std::map<std::string, std::string> grouped(const IdGrouping& grouping) {
  Scene scene = carFile().load();
  std::vector<uint32_t> before, after;
  for (const Instance& instance : scene.instances) before.push_back(instance.part);
  groupIds(scene, grouping);
  for (const Instance& instance : scene.instances) after.push_back(instance.part);
  EXPECT_EQ(before, after) << "parts are in no group";
  return idsOf(scene);
}

using Ids = std::map<std::string, std::string>;
const Ids kOwn = {{"/Car/Wheel", "/Car/Wheel"},
                  {"/Car/Wheel/Rim", "/Car/Wheel/Rim"},
                  {"/Car/Wheel#2", "/Car/Wheel#2"},
                  {"/Car/Door", "/Car/Door"},
                  {"/Road", "/Road"}};

TEST(Ids, AreThoseOfNodesAndTheirParts) {
  const Scene scene = carFile().load();
  EXPECT_EQ(idsOf(scene), kOwn);
  std::set<uint32_t> parts;
  for (const Instance& instance : scene.instances) {
    const Node& node = scene.nodes[instance.node];
    EXPECT_EQ(instance.part, hash32(fmt::format("{}/primitive{}", node.path, instance.primitive)));
    EXPECT_TRUE(parts.insert(instance.part).second);
    EXPECT_EQ(node.mesh, "Thing");
    EXPECT_EQ(instance.copy, -1);
  }
  EXPECT_EQ(parts.size(), 10u);
  EXPECT_EQ(scene.nodes[0].id, hash32("/Car"));
  EXPECT_EQ(scene.nodes[0].mesh, "");
}

TEST(Ids, GiveWayWhereTheyMeet) {
  UniqueIds ids;
  const auto name = [](const char* text) { return [text] { return std::string(text); }; };
  EXPECT_EQ(ids.make(7, name("a")), 7u);
  EXPECT_EQ(ids.make(7, name("b")), hash32("b~2"));
  EXPECT_EQ(ids.make(hash32("b~2"), name("c")), hash32("c~2"));
  EXPECT_EQ(ids.make(hash32("c~2"), name("c")), hash32("c~3"));
  EXPECT_EQ(ids.make(0, name("d")), hash32("d~2")) << "0 is background";
  EXPECT_EQ(ids.make("e"), hash32("e"));
}

// A copy is a single object for a user: one id for all of its primitives, below that of the node.
TEST(Ids, CopiesHaveIdsOfTheirOwn) {
  GltfBuilder b = carFile();
  const int places = b.positions({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  b.root["nodes"][3]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", places}};
  Scene scene = b.load();
  const auto check = [&](const std::function<uint32_t(int)>& idOf) {
    size_t copies = 0;
    for (const Instance& instance : scene.instances) {
      if (scene.nodes[instance.node].name != "Door") continue;
      ++copies;
      EXPECT_EQ(instance.id, idOf(instance.copy));
      EXPECT_EQ(instance.part,
                hash32(fmt::format("/Car/Door/instance{}/primitive{}", instance.copy, instance.primitive)));
    }
    EXPECT_EQ(copies, 6u);
  };
  const auto own = [](int copy) { return hash32(fmt::format("/Car/Door/instance{}", copy)); };
  check(own);
  EXPECT_EQ(scene.nodes[3].id, hash32("/Car/Wheel#2"));  // in the order of the scene, in which Rim precedes it
  groupIds(scene, {.depth = 2});
  check(own);  // they are at depth 2
  groupIds(scene, {.depth = 1});
  check([](int) { return hash32("/Car/Door"); });
}

TEST(Ids, OfMaterialsAreHashesOfTheirNames) {
  GltfBuilder b = triangleFile();
  for (const json& material : {json{{"name", "red"}}, json::object(), json{{"name", "red"}}})
    b.add("materials", material);
  const Scene scene = b.load();  // the triangle has none
  std::vector<uint32_t> ids;
  for (const Material& material : scene.materials) ids.push_back(material.data.id);
  EXPECT_THAT(ids, ElementsAre(hash32("red"), hash32("material1"), hash32("red~2"), hash32("default")));
  for (const char* name : {"builtin:boxes", "builtin:spheres"}) {
    std::set<uint32_t> unique{0};
    for (const Material& material : load(name).materials) EXPECT_TRUE(unique.insert(material.data.id).second) << name;
  }
}

TEST(IdGroups, ByDepth) {
  Ids ids = kOwn;
  EXPECT_EQ(grouped({.depth = 7}), ids);
  EXPECT_EQ(grouped({.depth = 2}), ids);
  ids["/Car/Wheel/Rim"] = "/Car/Wheel";
  EXPECT_EQ(grouped({.depth = 1}), ids);
  for (auto& [path, id] : ids) id = path == "/Road" ? "/Road" : "/Car";
  EXPECT_EQ(grouped({.depth = 0}), ids);
}

TEST(IdGroups, ByNamesAndPaths) {
  Ids ids = kOwn;
  ids["/Car/Wheel/Rim"] = "/Car/Wheel";
  EXPECT_EQ(grouped({.nodes = {"Wheel"}}), ids) << "both of them";
  EXPECT_EQ(grouped({.nodes = {"/Car/Wheel"}}), ids);
  EXPECT_EQ(grouped({.nodes = {"/Car/Wheel#2"}}), kOwn);
  for (auto& [path, id] : ids)
    if (path != "/Road") id = "/Car";
  EXPECT_EQ(grouped({.nodes = {"Car", "Road"}}), ids);
  ids["/Car/Wheel"] = ids["/Car/Wheel/Rim"] = "/Car/Wheel";
  EXPECT_EQ(grouped({.nodes = {"/Car/Wheel", "Car"}}), ids) << "the deepest that is listed counts";
}

TEST(IdGroups, WhatCantBeIsRefused) {
  const auto sentence = [](const IdGrouping& grouping) {
    try {
      grouped(grouping);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  EXPECT_THAT(sentence({.nodes = {"Car", "Boat"}}), HasSubstr("no node \"Boat\""));
  EXPECT_THAT(sentence({.nodes = {""}}), HasSubstr("no node \"\""));
  EXPECT_THAT(sentence({.depth = 1, .nodes = {"Car"}}), HasSubstr("one of them"));
}

}  // namespace
}  // namespace latelight::scene::test
