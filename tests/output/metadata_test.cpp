#include "output/metadata.h"

#include <nlohmann/json.hpp>

#include "support.h"

namespace latelight::output {
namespace {

using Json = nlohmann::ordered_json;

Metadata full() {
  Metadata m;
  m.scene = "helmet";
  m.source = "models/helmet.glb";
  m.frame = 3;
  m.camera.name = "left";
  m.camera.intrinsics = {700, 0, 640, 0, 700, 360, 0, 0, 1};
  m.camera.cameraToWorld =
      glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(0, -1, 0, 0), glm::dvec4(5, 6, 7, 1));
  m.camera.nearClip = 0.1;
  m.camera.farClip = std::numeric_limits<double>::infinity();
  m.normalFrame = "opencv";
  m.exposure = 2;
  m.device = {"llvmpipe", "Mesa 22.3.6", "00ff"};
  m.versions = {{"vulkan", "1.3"}, {"latelight", "0.1.0"}};
  m.settings = {{"tonemap", "aces"}};
  m.ids = {{4000000000u, "/Z", "mz", "mat"}, {5, "/A", "ma", ""}, {40, "/B", "mb", "mat"}};
  return m;
}

Json parsed(const std::vector<Aov>& aovs, const std::vector<std::string>& files) {
  return Json::parse(sideFile(full(), 1280, 720, aovs, files));
}

TEST(SideFile, HoldsAllThatAReaderNeeds) {
  const Json json = parsed({Aov::Depth, Aov::Normal}, {"a.depth.png", "a.normal.png"});
  for (const char* key : {"scene", "frame", "width", "height", "world", "camera", "exposure", "conventions", "aovs",
                          "device", "versions", "settings"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["scene"]["name"], "helmet");
  EXPECT_EQ(json["scene"]["source"], "models/helmet.glb");
  EXPECT_EQ(json["frame"], 3);
  EXPECT_EQ(json["width"], 1280);
  EXPECT_EQ(json["exposure"], 2);
  EXPECT_EQ(json["device"], Json({{"name", "llvmpipe"}, {"driver", "Mesa 22.3.6"}, {"uuid", "00ff"}}));
  EXPECT_EQ(json["versions"]["latelight"], "0.1.0");
  EXPECT_EQ(json["settings"]["tonemap"], "aces");
}

TEST(SideFile, DescribesTheCamera) {
  const Json camera = parsed({Aov::Depth}, {"a"})["camera"];
  EXPECT_EQ(camera["model"], "perspective");
  EXPECT_EQ(camera["convention"], "opencv");
  EXPECT_EQ(camera["K"], Json::parse("[[700.0,0.0,640.0],[0.0,700.0,360.0],[0.0,0.0,1.0]]"));
  EXPECT_EQ(camera["cameraToWorld"],
            Json::parse("[[1.0,0.0,0.0,5.0],[0.0,0.0,-1.0,6.0],[0.0,1.0,0.0,7.0],[0.0,0.0,0.0,1.0]]"));
  EXPECT_EQ(camera["near"], 0.1);
  EXPECT_EQ(camera["far"], "inf");
}

TEST(SideFile, DescribesEachAov) {
  const Json aovs = parsed({Aov::Depth, Aov::Normal, Aov::Position}, {"d", "n", "p"})["aovs"];
  ASSERT_EQ(aovs.size(), 3u);
  EXPECT_EQ(aovs["depth"]["file"], "d");
  EXPECT_EQ(aovs["depth"]["unit"], "m");
  EXPECT_EQ(aovs["depth"]["background"], "inf");
  EXPECT_EQ(aovs["depth"]["channels"], Json({"Z"}));
  EXPECT_EQ(aovs["normal"]["frame"], "opencv");
  EXPECT_EQ(aovs["normal"]["channels"], Json({"N.X", "N.Y", "N.Z"}));
  EXPECT_EQ(aovs["position"]["frame"], "world");
  const Json all = parsed(allAovs(), std::vector<std::string>(kAovCount, "f"))["aovs"];
  for (const auto& [name, aov] : all.items()) {
    for (const char* key : {"description", "unit", "channels", "background", "png", "file"}) {
      EXPECT_TRUE(aov.contains(key)) << name << " " << key;
    }
  }
}

TEST(IdManifest, HasDecimalKeysInOrder) {
  const Json ids = Json::parse(idManifest(full()));
  std::vector<std::string> keys;
  for (const auto& [key, entry] : ids.items()) {
    keys.push_back(key);
    EXPECT_EQ(entry.size(), 3u);
  }
  EXPECT_EQ(keys, (std::vector<std::string>{"5", "40", "4000000000"}));
  EXPECT_EQ(ids["40"], Json({{"node", "/B"}, {"mesh", "mb"}, {"material", "mat"}}));
}

TEST(IdManifest, TakesTheFirstOfEntriesWithOneId) {
  Metadata m;
  m.ids = {{7, "/first", "", ""}, {7, "/second", "", ""}};
  const std::string text = idManifest(m);
  EXPECT_THAT(text, testing::HasSubstr("/first"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("/second")));
}

TEST(IdManifest, IsInTheSideFileWithIds) {
  EXPECT_FALSE(parsed({Aov::Depth}, {"a"}).contains("ids"));
  EXPECT_EQ(parsed({Aov::Id}, {"a"})["ids"], Json::parse(idManifest(full())));
}

TEST(SideFile, SurvivesNamesThatAreNotUtf8) {
  Metadata m = full();
  m.ids[0].node = "/\xff\xfe\"\n";
  m.scene = std::string(1, '\xc3');
  const Json json = Json::parse(sideFile(m, 1, 1, std::vector{Aov::Id}, std::vector<std::string>{"a"}));
  EXPECT_EQ(json["ids"]["4000000000"]["node"], "/\xef\xbf\xbd\xef\xbf\xbd\"\n");
}

TEST(SideFile, OfManyObjectsIsQuick) {
  Metadata m;
  for (uint32_t i = 0; i < 200000; ++i) m.ids.push_back({i * 2654435761u, "/n", "m", "m"});
  const auto ids = nlohmann::json::parse(idManifest(m));  // with a search for each key it would take minutes
  EXPECT_EQ(ids.size(), 200000u);
}

}  // namespace
}  // namespace latelight::output
