#include "output/id_manifest.h"

#include <nlohmann/json.hpp>

#include "support.h"

namespace latelight::output {
namespace {

using Json = nlohmann::ordered_json;

// The group /A without a mesh, with the skinned /A/B of three parts and the copies of /A/C below it.
IdManifest some() {
  IdManifest manifest;
  manifest.ids = {{5, "/A", {}, 0, "", false, {}},
                  {40,
                   "/A/B",
                   {},
                   5,
                   "body",
                   true,
                   {{41, "/A/B", {}, "body", 0, 8}, {42, "/A/B", {}, "body", 2, 9}, {43, "/A/B", {}, "body", 3, 8}}},
                  {50, "/A/C", {}, 5, "leaf", false, {}},
                  {4000000000u, "/A/C", 7, 50, "leaf", false, {{51, "/A/C", 7, "leaf", 0, 9}}}};
  manifest.materials = {{8, "skin", 1}, {9, "cloth", 0}};
  return manifest;
}

TEST(IdManifest, SaysWhatIdsStandFor) {
  const Json json = Json::parse(idManifestText(some()));
  std::vector<std::string> keys;
  for (const auto& [key, entry] : json["ids"].items()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"5", "40", "50", "4000000000"}));
  EXPECT_EQ(json["ids"]["40"],
            Json({{"node", "/A/B"},
                  {"parent", 5},
                  {"mesh", "body"},
                  {"materials", {"skin", "cloth"}},
                  {"skinned", true},
                  {"parts",
                   {{{"id", 41}, {"node", "/A/B"}, {"mesh", "body"}, {"primitive", 0}, {"material", 8}},
                    {{"id", 42}, {"node", "/A/B"}, {"mesh", "body"}, {"primitive", 2}, {"material", 9}},
                    {{"id", 43}, {"node", "/A/B"}, {"mesh", "body"}, {"primitive", 3}, {"material", 8}}}}}));
  EXPECT_EQ(json["ids"]["5"]["materials"], Json::array());
  EXPECT_EQ(json["ids"]["5"]["parts"], Json::array());
  EXPECT_FALSE(json["ids"]["50"].contains("copy"));
  EXPECT_EQ(json["ids"]["4000000000"]["copy"], 7);
  EXPECT_EQ(json["ids"]["4000000000"]["parts"][0]["copy"], 7);
  EXPECT_EQ(json["materials"],
            Json({{"8", {{"name", "skin"}, {"index", 1}}}, {"9", {{"name", "cloth"}, {"index", 0}}}}));
}

TEST(IdManifest, OfManyObjectsIsQuick) {
  IdManifest manifest;
  for (uint32_t i = 0; i < 200000; ++i) manifest.ids.push_back({.id = i + 1, .node = "/n", .mesh = "m"});
  // A search for each key would take minutes; the ordered Json reads the keys with a single one.
  const auto json = nlohmann::json::parse(idManifestText(manifest));
  EXPECT_EQ(json["ids"].size(), 200000u);
}

AovImage picture(Aov aov, std::vector<uint32_t> ids) {
  AovImage image = makeAovImage(aov, static_cast<uint32_t>(ids.size()), 1);
  image.ids = std::move(ids);
  return image;
}

std::vector<std::string> nodesOf(const IdManifest& manifest) {
  std::vector<std::string> nodes;
  for (const IdEntry& entry : manifest.ids) nodes.push_back(entry.node);
  return nodes;
}

TEST(ShownIds, AreThoseOfThePicturesWithTheNodesAbove) {
  using testing::ElementsAre;
  using testing::IsEmpty;
  IdManifest all;
  all.ids = {{.id = 2, .node = "/a"},
             {.id = 3, .node = "/a/b", .parent = 2, .parts = {{.id = 30, .material = 7}, {.id = 31, .material = 8}}},
             {.id = 4, .node = "/c", .parts = {{.id = 40, .material = 9}}},
             {.id = 5, .node = "/a/b/d", .parent = 3, .parts = {{.id = 50, .material = 9}}}};
  all.materials = {{7, "red"}, {8, "green"}, {9, "blue"}};
  const auto shown = [&](std::vector<AovImage> pictures) { return shownIn(all, pictures); };
  EXPECT_THAT(nodesOf(shown({picture(Aov::Id, {0, 0, 3, 3, 0})})), ElementsAre("/a", "/a/b"));
  EXPECT_THAT(nodesOf(shown({picture(Aov::Id, {4, 5, 4})})), ElementsAre("/a", "/a/b", "/c", "/a/b/d"));
  EXPECT_THAT(nodesOf(shown({picture(Aov::Part, {40})})), ElementsAre("/c"));
  EXPECT_EQ(shown({picture(Aov::Id, {3})}).materials.size(), 2u);
  const IdManifest material = shown({picture(Aov::Material, {8, 0})});
  EXPECT_THAT(material.ids, IsEmpty());
  ASSERT_EQ(material.materials.size(), 1u);
  EXPECT_EQ(material.materials[0].name, "green");
  EXPECT_THAT(shown({picture(Aov::Id, {0})}).materials, IsEmpty());
}

}  // namespace
}  // namespace latelight::output
