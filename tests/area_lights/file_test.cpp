// Area lights in glTF files, exported files and the public API.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <fstream>

#include "app/folder.h"
#include "base/error.h"
#include "base/log.h"
#include "error_of.h"
#include "export/export.h"
#include "scene/load/load.h"
#include "shared/light.h"

namespace latelight::test {
namespace {

using glm::dvec3;
using glm::vec3;
using testing::HasSubstr;

class AreaLightFileTest : public testing::Test {
 protected:
  // Writes a file with one node.
  std::string fileOf(const std::string& areaLight, const std::string& node = "") const {
    const std::string path = folder_.at("scene.gltf");
    std::ofstream(path) << fmt::format(
        R"({{"asset": {{"version": "2.0"}}, "nodes": [{{"name": "{}", {}"extras": {{"areaLight": {}}}}}]}})", name_,
        node, areaLight);
    return path;
  }
  scene::Scene loaded(const std::string& areaLight, const std::string& node = "") const {
    return scene::load(fileOf(areaLight, node));
  }
  scene::Light light(const std::string& areaLight, const std::string& node = "") const {
    const scene::Scene scene = loaded(areaLight, node);
    EXPECT_EQ(scene.lights.size(), 1u);
    return scene.lights.empty() ? scene::Light{} : scene.lights.front();
  }
  // The warning with which the light is left out.
  std::string warningOf(const std::string& areaLight) {
    name_ += "x";  // a warning is logged once
    testing::internal::CaptureStderr();
    EXPECT_TRUE(loaded(areaLight).lights.empty()) << areaLight;
    return testing::internal::GetCapturedStderr();
  }
  const app::Folder folder_;
  std::string name_ = "lamp";
};

TEST_F(AreaLightFileTest, ReadsThePropertiesOfTheDraft) {
  const scene::Light rect = light(
      R"({"type": "rect", "size": 0.5, "rect": {"aspect": 3}, "intensity": 20, "color": [1, 0.5, 0], "twoSided": true})");
  EXPECT_EQ(rect.type, shared::kLightRect);
  EXPECT_EQ(rect.name, "lamp");
  EXPECT_EQ(rect.width, 1.5f);
  EXPECT_EQ(rect.height, 0.5f);
  EXPECT_EQ(rect.intensity, 20);
  EXPECT_EQ(rect.color, vec3(1, 0.5f, 0));
  EXPECT_TRUE(rect.twoSided);
  const scene::Light disk = light(R"({"type": "disk", "size": 0.5, "name": "round", "castShadow": false})");
  EXPECT_EQ(disk.type, shared::kLightDisk);
  EXPECT_EQ(disk.name, "round");
  EXPECT_EQ(disk.size, 0.25f);
  EXPECT_EQ(disk.intensity, 1);
  EXPECT_EQ(disk.castShadow, std::optional(false));
  EXPECT_EQ(light(R"({"type": "sphere"})").size, 0.5f);
  const scene::Light tube = light(R"({"type": "tube", "size": 0.1, "tube": {"length": 2}})");
  EXPECT_EQ(tube.size, 0.05f);
  EXPECT_EQ(tube.length, 2);
}

// The whole transform applies: the file's Y is the world's Z, and its Z is the world's -Y.
TEST_F(AreaLightFileTest, FollowsTheTransformOfItsNode) {
  const scene::Light moved = light(R"({"type": "rect"})", R"("translation": [1, 2, 3], "scale": [2, -3, 4], )");
  EXPECT_EQ(moved.position, dvec3(1, -3, 2));
  EXPECT_EQ(moved.axes, glm::mat3(vec3(2, 0, 0), vec3(0, 0, -3), vec3(0, -4, 0)));
  EXPECT_EQ(moved.direction, vec3(0, 1, 0));
}

TEST_F(AreaLightFileTest, LeavesOutInvalidLightsWithASentence) {
  for (const auto& [json, sentence] : std::initializer_list<std::pair<const char*, const char*>>{
           {"5", "it is not an object"},
           {"{}", "its type must be rect, disk, sphere or tube, not \"\""},
           {R"({"type": "spot"})", "its type must be rect, disk, sphere or tube, not \"spot\""},
           {R"({"type": 7})", "its type is not a string"},
           {R"({"type": "rect", "size": 0})", "its size must be above 0, not 0"},
           {R"({"type": "disk", "size": -1})", "its size must be above 0, not -1"},
           {R"({"type": "disk", "size": "big"})", "its size must be a finite number"},
           {R"({"type": "disk", "size": 1e300})", "its size must be a finite number"},
           {R"({"type": "disk", "size": 1e-300})", "its size must be above 0"},
           {R"({"type": "rect", "rect": {"aspect": 0}})", "its aspect must be above 0, not 0"},
           {R"({"type": "rect", "rect": [1]})", "it is not an object"},
           {R"({"type": "rect", "size": 1e30, "rect": {"aspect": 1e30}})", "its width is out of range"},
           {R"({"type": "tube", "tube": {"length": -2}})", "its length must be above 0, not -2"},
           {R"({"type": "rect", "intensity": -1})", "its intensity must be at least 0, not -1"},
           {R"({"type": "rect", "color": [1, 1]})", "its color must have three numbers"},
           {R"({"type": "rect", "color": [1, -1, 0]})", "its color must have three numbers of at least 0"},
           {R"({"type": "rect", "color": [1, "x", 0]})", "its color must have three numbers of at least 0"},
           {R"({"type": "rect", "twoSided": 1})", "its twoSided must be true or false"},
           {R"({"type": "sphere", "twoSided": true})", "only a rect or a disk can be twoSided"},
           {R"({"type": "rect", "name": {}})", "its name is not a string"}}) {
    const std::string warning = warningOf(json);
    EXPECT_THAT(warning, HasSubstr(fmt::format("in the extras of /{} is left out: {}", name_, sentence))) << json;
  }
}

TEST_F(AreaLightFileTest, IsTheSameAfterExport) {
  for (const char* json :
       {R"({"type": "rect", "size": 0.7, "rect": {"aspect": 1.3}, "twoSided": true, "intensity": 0.1})",
        R"({"type": "disk", "size": 0.3, "color": [0.1, 0.2, 0.3], "castShadow": true})",
        R"({"type": "sphere", "size": 0.3, "name": "bulb"})",
        R"({"type": "tube", "size": 0.05, "tube": {"length": 1.1}})"})
    for (const char* node : {"", R"("rotation": [0, 0.6, 0, 0.8], "scale": [1, 2, -3], )"}) {
      const scene::Scene scene = loaded(json, node);
      exports::exportScene(scene, folder_.at("out.glb"));
      const scene::Scene again = scene::load(folder_.at("out.glb"));
      ASSERT_EQ(again.lights.size(), 1u) << json;
      scene::Light a = scene.lights[0], b = again.lights[0];
      b.node = a.node;
      EXPECT_LT(glm::length(a.position - b.position), 1e-6);
      for (int i = 0; i < 3; ++i) EXPECT_LT(glm::length(a.axes[i] - b.axes[i]), 1e-6f) << json;
      a.axes = b.axes, a.position = b.position, a.direction = b.direction;
      EXPECT_EQ(a, b) << json;
    }
}

// --- the public API --------------------------------------------------------------------------------------------------

Light ceiling() {
  Light light;
  light.type = "rect";
  light.position = {1, 3, 0};
  light.direction = {0, -1, 0};
  light.width = 1.2;
  light.height = 0.6;
  light.intensity = 5;
  return light;
}

std::string refusal(const Light& light) {
  Scene scene;
  return errorOf([&] { scene.addLight(light); });
}

TEST(AreaLightApi, ReturnsWhatWasSet) {
  Scene scene;
  Light light = ceiling();
  light.up = {0.6f, 0, 0.8f};
  light.scale = {1, 2, 1};
  light.twoSided = true;
  const Handle<Light> handle = scene.addLight(light);
  const Light back = scene.light(handle);
  EXPECT_EQ(back.type, "rect");
  EXPECT_EQ(back.width, static_cast<float>(light.width));
  EXPECT_EQ(back.height, static_cast<float>(light.height));
  EXPECT_TRUE(back.twoSided);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(back.position[i], light.position[i], 1e-6);
    EXPECT_NEAR(back.direction[i], light.direction[i], 1e-6);
    EXPECT_NEAR(back.up[i], light.up[i], 1e-6);
    EXPECT_NEAR(back.scale[i], light.scale[i], 1e-6);
  }
  Light tube = back;
  tube.type = "tube";
  tube.twoSided = false;
  tube.size = 0.1;
  tube.length = 2;
  scene.setLight(handle, tube);
  EXPECT_EQ(scene.light(handle).length, 2);
  EXPECT_EQ(scene.light(handle).type, "tube");
}

TEST(AreaLightApi, RefusesInvalidValuesWithASentence) {
  const auto with = [](auto change) {
    Light light = ceiling();
    light.name = "panel";
    change(light);
    return refusal(light);
  };
  Scene().addLight(ceiling());
  EXPECT_THAT(with([](Light& l) { l.width = 0; }),
              HasSubstr("the width of the light \"panel\" must be above 0, not 0"));
  EXPECT_THAT(with([](Light& l) { l.height = -1; }), HasSubstr("the height of the light \"panel\" must be above 0"));
  EXPECT_THAT(with([](Light& l) { l.type = "disk"; }), HasSubstr("the size of the light \"panel\" must be above 0"));
  EXPECT_THAT(with([](Light& l) { l.type = "tube", l.size = 1, l.length = 0; }),
              HasSubstr("the length of the light \"panel\" must be above 0"));
  EXPECT_THAT(with([](Light& l) { l.type = "sphere", l.size = 1, l.twoSided = true; }),
              HasSubstr("only rect and disk lights have two sides"));
  EXPECT_THAT(with([](Light& l) { l.range = 5.0f; }), HasSubstr("can't have a range: area lights are unbounded"));
  EXPECT_THAT(with([](Light& l) { l.up = {0, 0, 0}; }), HasSubstr("must be finite and not zero"));
  EXPECT_THAT(with([](Light& l) { l.scale = {1, NAN, 1}; }), HasSubstr("must be finite"));
  EXPECT_THAT(with([](Light& l) { l.direction = {0, 0, 0}; }), HasSubstr("must be finite and not zero"));
  EXPECT_THAT(with([](Light& l) { l.intensity = -1; }), HasSubstr("intensity"));
}

}  // namespace
}  // namespace latelight::test
