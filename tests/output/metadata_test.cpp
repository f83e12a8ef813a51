#include "output/metadata.h"

#include <cmath>
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
  m.ids = std::make_shared<IdManifest>(
      IdManifest{.ids = {{.id = 5, .node = "/A"}, {.id = 4000000000u, .node = "/A/Z", .parent = 5}}});
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

// A factor of 1/8, metered, is -3 EV; the camera's sensor saturates at luminance 8.
TEST(SideFile, StatesAMeteredExposure) {
  EXPECT_FALSE(parsed({Aov::Depth}, {"a"}).contains("metered"));
  Metadata metered = full();
  metered.exposure = 0.125f, metered.metered = true;
  const Json json = Json::parse(sideFile(metered, 4, 4, std::vector{Aov::Depth}, {}));
  EXPECT_EQ(json["exposure"], 0.125);
  EXPECT_EQ(json["metered"]["ev"], -3);
  EXPECT_NEAR(1.2 * std::exp2(json["metered"]["ev100"].get<double>()), 8, 1e-6);
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

TEST(SideFile, DescribesTheLens) {
  Metadata m = full();
  m.camera.lens = scene::Lens{scene::LensModel::Fisheye, 1280, 720, 300, 310, 640, 360, {0.1, 0.2, 0.3, 0.4}};
  const auto cameraOf = [&] {
    return Json::parse(sideFile(m, 1280, 720, std::vector{Aov::Depth}, std::vector<std::string>{"a"}))["camera"];
  };
  EXPECT_EQ(cameraOf()["model"], "fisheye");
  EXPECT_EQ(cameraOf()["distortion"], Json({0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(cameraOf()["K"], Json::parse("[[700.0,0.0,640.0],[0.0,700.0,360.0],[0.0,0.0,1.0]]"));
  m.camera.lens = scene::Lens{.model = scene::LensModel::CubeMap};
  EXPECT_EQ(cameraOf()["model"], "cubemap");
  EXPECT_TRUE(cameraOf()["K"].is_null());
  EXPECT_TRUE(cameraOf()["distortion"].is_null());
  EXPECT_FALSE(parsed({Aov::Depth}, {"a"})["camera"].contains("distortion"));
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

TEST(SideFile, HasTheIdManifestOfOutputsThatHoldIds) {
  EXPECT_FALSE(parsed({Aov::Depth}, {"a"}).contains("ids"));
  for (const Aov aov : {Aov::Id, Aov::Part, Aov::Material}) {
    const Json json = parsed({aov}, {"a"}), manifest = Json::parse(idManifestText(*full().ids));
    EXPECT_EQ(json["ids"], manifest["ids"]);
    EXPECT_EQ(json["materials"], manifest["materials"]);
    EXPECT_EQ(json["ids"].size(), 2u);
  }
}

TEST(SideFile, SurvivesNamesThatAreNotUtf8) {
  Metadata m = full();
  m.ids = std::make_shared<IdManifest>(IdManifest{.ids = {{.id = 4000000000u, .node = "/\xff\xfe\"\n"}}});
  m.scene = std::string(1, '\xc3');
  const Json json = Json::parse(sideFile(m, 1, 1, std::vector{Aov::Id}, std::vector<std::string>{"a"}));
  EXPECT_EQ(json["ids"]["4000000000"]["node"], "/\xef\xbf\xbd\xef\xbf\xbd\"\n");
}

}  // namespace
}  // namespace latelight::output
