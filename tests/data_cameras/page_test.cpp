// The examples of docs/cameras.md are valid and create cameras.
#include <fstream>

#include "data/cameras/bop.h"
#include "data/cameras/colmap.h"
#include "data/cameras/source.h"
#include "data/cameras/transforms.h"
#include "data/cameras/tum.h"
#include "data_cameras/support.h"
#include "scene/load/load.h"

namespace latelight::data::test {
namespace {

std::vector<std::string> examplesOf(const std::string& page) {
  std::ifstream file(std::string(LATELIGHT_SOURCE_DIR) + "/docs/" + page);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string begin = "```json\n", end = "```";
  std::vector<std::string> examples;
  for (size_t at = text.find(begin); at != text.npos; at = text.find(begin, at)) {
    at += begin.size();
    examples.push_back(text.substr(at, text.find(end, at) - at));
  }
  return examples;
}

// The files that the page mentions, in the working folder of a test.
class PageTest : public testing::Test {
 protected:
  PageTest() : before_(std::filesystem::current_path()) {
    const scene::Lens lens{.width = 640, .height = 480, .fx = 525, .fy = 525, .cx = 320, .cy = 240};
    const std::vector<CalibratedCamera> cameras{{"1", lens, dmat4(1)}, {"2", lens, dmat4(1)}};
    std::filesystem::current_path(folder_.path());
    std::filesystem::create_directories("sparse/0");
    writeTransforms("transforms.json", cameras);
    writeColmapBinary("sparse/0", cameras);
    writeTum("groundtruth.txt", cameras);
    writeBop("scene_camera.json", cameras, 1);
  }
  ~PageTest() override { std::filesystem::current_path(before_); }

 private:
  Folder folder_;
  std::filesystem::path before_;
};

void addTypes(const Json& value, std::set<std::string>& types) {
  if (value.is_object() && value.contains("type")) types.insert(value["type"].get<std::string>());
  if (value.is_structured())
    for (const Json& part : value) addTypes(part, types);
}

TEST_F(PageTest, ExamplesMakeCameras) {
  std::set<std::string> types;
  scene::Scene scene = scene::load("builtin:boxes");
  scene.cameras[0].name = "front";
  for (const std::string& example : examplesOf("cameras.md")) {
    SCOPED_TRACE(example);
    EXPECT_FALSE(made(example, scene).empty());
    addTypes(Json::parse(example), types);
  }
  for (const CameraSource& source : cameraSources())
    EXPECT_TRUE(types.contains(std::string(source.name))) << source.name;
}

// A key that the schema does not contain is rejected, and the schema contains every source.
TEST(SchemaTest, HasEachSource) {
  std::ifstream file(std::string(LATELIGHT_SOURCE_DIR) + "/src/data/cameras/schema.json");
  const Json schema = Json::parse(file);
  EXPECT_EQ(schema["$defs"]["source"]["oneOf"].size(), cameraSources().size());
  for (const CameraSource& source : cameraSources()) {
    const Json& own = schema["$defs"][std::string(source.name)];
    EXPECT_EQ(own["properties"]["type"]["const"], source.name);
    EXPECT_EQ(own["description"], source.description);
  }
}

}  // namespace
}  // namespace latelight::data::test
