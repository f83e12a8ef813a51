// Motion of data sets: from each frame to the previous and the next one, if the set has them. A square at z = 0 fills
// the pictures of cameras at z = 4 with a focal length of 40 pixels: an object that moves right by d has a flow of 40 d
// / 4 = 10 d pixels, and a camera that moves by d causes a flow of -10 d everywhere.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "batch/sets.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;
using nlohmann::json;
using testing::ElementsAre;

constexpr double kFocal = 40;
constexpr float kUnknown = 1e10f;

// The square [-40, 40]^2 of the node "square", and a camera at z = 4. The node named by `moves`, if any, moves right by
// one meter per second, from 0 s to 10 s.
void writeScene(const Folder& folder, const std::string& file, const std::string& moves = "") {
  const float positions[] = {-40, -40, 0, 40, -40, 0, 40, 40, 0, -40, 40, 0};
  const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  const float times[] = {0, 10}, square[] = {0, 0, 0, 10, 0, 0}, camera[] = {0, 0, 4, 10, 0, 4};
  std::string buffer;
  json views = json::array();
  const auto add = [&](const void* data, size_t bytes) {
    views.push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes}});
    buffer.append(static_cast<const char*>(data), bytes);
  };
  add(positions, sizeof(positions));
  add(indices, sizeof(indices));
  add(times, sizeof(times));
  add(square, sizeof(square));
  add(camera, sizeof(camera));
  folder.write(file + ".bin", std::string_view(buffer));
  json root{
      {"asset", {{"version", "2.0"}}},
      {"scenes", {{{"nodes", {0, 1}}}}},
      {"nodes", {{{"name", "square"}, {"mesh", 0}}, {{"name", "camera"}, {"camera", 0}, {"translation", {0, 0, 4}}}}},
      // A focal length of 40 pixels for 24 rows.
      {"cameras", {{{"type", "perspective"}, {"perspective", {{"yfov", 2 * std::atan(12 / kFocal)}, {"znear", 0.1}}}}}},
      {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
      {"buffers", {{{"uri", file + ".bin"}, {"byteLength", buffer.size()}}}},
      {"bufferViews", views},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 4},
         {"type", "VEC3"},
         {"min", {-40, -40, 0}},
         {"max", {40, 40, 0}}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}},
        {{"bufferView", 2}, {"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}, {"min", {0}}, {"max", {10}}},
        {{"bufferView", 3}, {"componentType", 5126}, {"count", 2}, {"type", "VEC3"}},
        {{"bufferView", 4}, {"componentType", 5126}, {"count", 2}, {"type", "VEC3"}}}}};
  if (!moves.empty())
    root["animations"] = {
        {{"samplers", {{{"input", 2}, {"output", moves == "square" ? 3 : 4}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", moves == "square" ? 0 : 1}, {"path", "translation"}}}}}}}};
  folder.write(file, std::string_view(root.dump()));
}

Outcome make(const Folder& folder, const std::string& scene, const std::string& cameras,
             std::vector<std::string> more = {}) {
  std::vector<std::string> all{"--scenes",  scene,
                               "--formats", "flow",
                               "--formats", R"({"format": "flow", "to": "previous", "file": "back/{name}.flo"})"};
  json job;
  job["cameras"] = json::parse(cameras);
  folder.write("job.json", std::string_view(job.dump()));
  all.insert(all.begin(), "job.json");
  if (std::ranges::find(more, "-o") == more.end()) all.insert(all.end(), {"-o", "set"});
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

// Returns the horizontal flow of a file, which must be equal in all pixels. The vertical flow must be 0. Both are 1e10
// if unknown.
double flowIn(const Folder& folder, const std::string& file) {
  const std::string bytes = folder.read("set/" + file);
  EXPECT_EQ(bytes.size(), 12u + 8 * 32 * 24) << file;
  if (bytes.size() < 12u + 8 * 32 * 24) return NAN;
  std::vector<float> flow(2 * 32 * 24);
  std::memcpy(flow.data(), bytes.data() + 12, flow.size() * sizeof(float));
  for (size_t i = 0; i < flow.size(); i += 2) {
    EXPECT_NEAR(flow[i], flow[0], 1e-3) << file;
    EXPECT_NEAR(flow[i + 1], flow[0] == kUnknown ? kUnknown : 0, 1e-3) << file;
  }
  return flow[0];
}

// Expects the flow of frames 0 to n - 1: to the next frame, or to the previous one.
std::vector<double> flowsOf(const Folder& folder, size_t frames, const char* kind = "flow") {
  std::vector<double> flows;
  for (size_t i = 0; i < frames; ++i) flows.push_back(flowIn(folder, fmt::format("{}/{:06}.flo", kind, i)));
  return flows;
}

auto near(std::vector<double> flows) {
  std::vector<testing::Matcher<double>> each;
  for (const double flow : flows) each.push_back(testing::DoubleNear(flow, 1e-3));
  return testing::ElementsAreArray(each);
}

json motionOf(const Folder& folder) {
  json motion = json::array();
  const json manifest = json::parse(folder.read("set/manifest.json"));
  for (const json& frame : manifest.at("frames")) motion.push_back(frame.at("motion"));
  return motion;
}

// --- cameras with an order ------------------------------------------------------------------------------------------

// Three poses: the second is 0.1 m to the right of the first, the third another 0.3 m.
struct Source {
  const char* name;
  std::string cameras;  // value of the job's key
  void (*write)(const Folder& folder) = nullptr;
};

constexpr double kPoses[] = {0, 0.1, 0.4};

void writeTum(const Folder& folder) {
  std::string text;
  for (size_t i = 0; i < 3; ++i) text += fmt::format("{}.5 {} 0 4 1 0 0 0\n", i, kPoses[i]);
  folder.write("tum.txt", std::string_view(text));
}

void writeTransforms(const Folder& folder) {
  json root{{"w", 32}, {"h", 24}, {"fl_x", kFocal}};
  for (const double x : kPoses)
    root["frames"].push_back({{"transform_matrix", {{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
  folder.write("transforms.json", std::string_view(root.dump()));
}

// The images are unordered in the file; their names determine the order.
void writeColmap(const Folder& folder) {
  fs::create_directory(folder.path() / "sparse");
  folder.write("sparse/cameras.txt", std::string_view("1 SIMPLE_PINHOLE 32 24 40 16 12\n"));
  std::string images;
  for (const size_t i : {2, 0, 1})
    images += fmt::format("{} 0 1 0 0 {} 0 4 1 r_{}.png\n\n", 7 - i, -kPoses[i], 9 + i);  // r_9, r_10, r_11
  folder.write("sparse/images.txt", std::string_view(images));
}

void writeBop(const Folder& folder) {
  json root;
  for (size_t i = 0; i < 3; ++i)
    root[std::to_string(5 * i)] = {{"cam_K", {kFocal, 0, 15.5, 0, kFocal, 11.5, 0, 0, 1}},
                                   {"cam_R_w2c", {1, 0, 0, 0, -1, 0, 0, 0, -1}},
                                   {"cam_t_w2c", {-1000 * kPoses[i], 0, 4000}}};
  folder.write("scene_camera.json", std::string_view(root.dump()));
}

const std::string kLens = R"("K": [[40, 0, 16], [0, 40, 12], [0, 0, 1]])";

TEST(MotionOfASet, LeadsToTheNeighborsOfEachOrderedSource) {
  const Source sources[] = {{"TUM", R"({"type": "tum", "file": "tum.txt", )" + kLens + "}", writeTum},
                            {"transforms", R"({"type": "transforms", "file": "transforms.json"})", writeTransforms},
                            {"COLMAP", R"({"type": "colmap", "folder": "sparse"})", writeColmap},
                            {"BOP", R"({"type": "bop", "file": "scene_camera.json"})", writeBop},
                            {"path", R"({"type": "path", "fps": 1, "rotation": "slerp", )" + kLens + R"(, "keys": [
          {"time": 0, "eye": [0, 0, 4], "target": [0, 0, 0]}, {"time": 1, "eye": [0.1, 0, 4], "target": [0.1, 0, 0]},
          {"time": 2, "eye": [0.4, 0, 4], "target": [0.4, 0, 0]}]})"}};
  app::inPairs(std::size(sources), [&](size_t i) {
    SCOPED_TRACE(sources[i].name);
    const Folder folder;
    writeScene(folder, "s.gltf");
    if (sources[i].write) sources[i].write(folder);
    const Outcome outcome = make(folder, "s.gltf", sources[i].cameras);
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_THAT(flowsOf(folder, 3), near({-1, -3, kUnknown}));
    EXPECT_THAT(flowsOf(folder, 3, "back"), near({kUnknown, 1, 3}));
    EXPECT_EQ(motionOf(folder), json::parse(R"([{"previous": null, "next": {"frame": "000001"}},
        {"previous": {"frame": "000000"}, "next": {"frame": "000002"}},
        {"previous": {"frame": "000001"}, "next": null}])"));
  });
}

// The next frame of each member belongs to the same member. The sequence begins again with each variation.
TEST(MotionOfASet, OfAPairLeadsToTheSameMember) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  writeTum(folder);
  const Outcome outcome =
      make(folder, "s.gltf",
           R"({"type": "stereo", "baseline": 0.05, "cameras": {"type": "tum", "file": "tum.txt", )" + kLens + "}}",
           {"--repeat", "2", "--name", "{variation}/{camera}-{index}"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json motion = motionOf(folder);
  std::vector<double> flows;
  for (const char* name : {"0/0.5-left-000000", "0/0.5-right-000001", "0/1.5-left-000002", "0/1.5-right-000003",
                           "0/2.5-left-000004", "0/2.5-right-000005", "1/0.5-left-000006"})
    flows.push_back(flowIn(folder, fmt::format("flow/{}.flo", name)));
  EXPECT_THAT(flows, near({-1, -1, -3, -3, kUnknown, kUnknown, -1}));
  EXPECT_EQ(motion[3]["next"], json({{"frame", "0/2.5-right-000005"}}));
  EXPECT_EQ(motion[6]["previous"], json());
}

// Several cameras with a folder of images each: the first image of one camera does not follow the last of another.
TEST(MotionOfASet, KeepsToTheFolderOfItsPictures) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  json root{{"w", 32}, {"h", 24}, {"fl_x", kFocal}};
  for (const char* file : {"left/1.png", "right/1.png", "left/2.png", "right/2.png"}) {
    const double x = std::string_view(file).ends_with("1.png") ? 0 : 0.2;
    root["frames"].push_back(
        {{"file_path", file}, {"transform_matrix", {{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
  }
  folder.write("transforms.json", std::string_view(root.dump()));
  const Outcome outcome = make(folder, "s.gltf", R"({"type": "transforms", "file": "transforms.json"})");
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(flowsOf(folder, 4), near({-2, -2, kUnknown, kUnknown}));
}

// --- cameras without an order ---------------------------------------------------------------------------------------

TEST(MotionOfASet, IsUnknownWithoutAnOrder) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  const std::string cameras =
      R"([{"type": "list", )" + kLens + R"(, "cameras": [{"eye": [0, 0, 4], "target": [0, 0, 0]},
      {"eye": [1, 0, 4], "target": [1, 0, 0]}]}, {"type": "scene"}])";
  const Outcome outcome = make(folder, "s.gltf", cameras);
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  for (const char* kind : {"flow", "back"}) EXPECT_THAT(flowsOf(folder, 3, kind), near({kUnknown, kUnknown, kUnknown}));
  for (const json& motion : motionOf(folder)) EXPECT_EQ(motion, json({{"previous", nullptr}, {"next", nullptr}}));
}

// The second camera is beyond the square, which it has behind it, and sees the environment in the same direction as the
// first, without flow.
TEST(MotionOfASet, IsUnknownBehindTheOtherCamera) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  const std::string path = R"({"type": "path", "count": 2, )" + kLens + R"(, "keys": [
      {"eye": [0, 0, 4], "target": [0, 0, 3]}, {"eye": [0, 0, -1], "target": [0, 0, -2]}]})";
  const Outcome outcome =
      make(folder, "s.gltf", path, {"--formats", R"({"format": "flow", "as": "kitti", "file": "k/{name}.png"})"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(flowsOf(folder, 2), near({kUnknown, kUnknown}));
  EXPECT_THAT(flowsOf(folder, 2, "back"), near({kUnknown, 0}));
}

// A square that is turned away from is behind the other camera, and so is the environment.
TEST(MotionOfASet, IsUnknownIfTheCameraTurnsAround) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  const std::string path = R"({"type": "path", "count": 2, )" + kLens + R"(, "keys": [
      {"pose": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 4], [0, 0, 0, 1]]},
      {"pose": [[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]})";
  const Outcome outcome = make(folder, "s.gltf", path);
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(flowsOf(folder, 2), near({kUnknown, kUnknown}));
  EXPECT_THAT(flowsOf(folder, 2, "back"), near({kUnknown, kUnknown}));
}

// The square moves by 0.1 m per frame; a camera of a list is static.
TEST(MotionOfASet, OfAMovingSceneIsThatOfTheScene) {
  const Folder folder;
  writeScene(folder, "s.gltf", "square");
  const std::string list =
      R"({"type": "list", )" + kLens + R"(, "cameras": [{"eye": [0, 0, 4], "target": [0, 0, 0]}]})";
  const Outcome outcome = make(folder, "s.gltf", list, {"--time", "2", "--fps", "10"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(flowsOf(folder, 1), near({1}));
  EXPECT_THAT(flowsOf(folder, 1, "back"), near({-1}));
  EXPECT_EQ(motionOf(folder)[0], json({{"previous", {{"time", 1.9}}}, {"next", {{"time", 2.1}}}}));
}

// --- the scene's time -----------------------------------------------------------------------------------------------

// Camera and square both move by 0.1 m from frame to frame, so there is no flow. With a fixed time only the camera
// moves.
TEST(MotionOfASet, TimeAdvancesFromFrameToFrame) {
  const std::string path = R"({"type": "path", "fps": 10, )" + kLens + R"(, "keys": [
      {"time": 0, "eye": [0, 0, 4], "target": [0, 0, 0]}, {"time": 0.2, "eye": [0.2, 0, 4], "target": [0.2, 0, 0]}]})";
  json root{{"w", 32}, {"h", 24}, {"fl_x", kFocal}};
  for (const double x : {0.0, 0.1, 0.2})
    root["frames"].push_back({{"transform_matrix", {{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
  const std::string transforms = R"({"type": "transforms", "file": "transforms.json"})";
  struct Case {
    std::string cameras;
    std::vector<std::string> options;
    double flow, last;  // the flow in pixels, and the time of the last frame
  };
  const Case cases[] = {{path, {"--time", "1"}, 0, 1.2},
                        {transforms, {"--time", "1", "--fps", "10"}, 0, 1.2},
                        {transforms, {"--time", "1"}, -1, 1},
                        {transforms, {}, -1, 0}};
  app::inPairs(std::size(cases), [&](size_t i) {
    SCOPED_TRACE(i);
    const Folder folder;
    writeScene(folder, "s.gltf", "square");
    folder.write("transforms.json", std::string_view(root.dump()));
    std::vector<std::string> options = cases[i].options;
    options.insert(options.end(),
                   {"--formats", R"({"format": "files", "outputs": ["motion"], "pattern": "{name}.exr"})"});
    const Outcome outcome = make(folder, "s.gltf", cases[i].cameras, options);
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_THAT(flowsOf(folder, 3), near({cases[i].flow, cases[i].flow, kUnknown}));
    const json side = json::parse(folder.read("set/000002.json"));
    EXPECT_EQ(side["settings"].value("time", ""), cases[i].last > 0 ? fmt::format("{}", cases[i].last) : "");
    EXPECT_EQ(side["aovs"]["motion"]["frames"]["next"], json());
    EXPECT_EQ(side["aovs"]["motion"]["frames"]["previous"]["frame"], "000001");
  });
}

// The file's camera moves by one meter per second. At 2 s it is at x = 2, as is the left camera of a pair.
TEST(MotionOfASet, TheScenesCameraIsWhereItIsAtTheTime) {
  const Folder folder;
  writeScene(folder, "s.gltf", "camera");
  const std::string cameras =
      R"([{"type": "scene"}, {"type": "stereo", "baseline": 0.5, "cameras": {"type": "scene"}}])";
  const Outcome outcome =
      make(folder, "s.gltf", cameras,
           {"--time", "2", "--fps", "10", "--formats", R"({"format": "transforms", "depth": false})"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  std::vector<double> places;
  const json transforms = json::parse(folder.read("set/transforms.json"));
  for (const json& frame : transforms.at("frames")) places.push_back(frame["transform_matrix"][0][3]);
  EXPECT_THAT(places, near({2, 2, 2.5}));
  EXPECT_THAT(flowsOf(folder, 3), near({-1, -1, -1}));
  EXPECT_THAT(flowsOf(folder, 3, "back"), near({1, 1, 1}));
}

// --- parts of a set -------------------------------------------------------------------------------------------------

TEST(MotionOfASet, IsTheSameInPartsAndOnceItIsResumed) {
  const Folder folder;
  writeScene(folder, "s.gltf");
  writeTum(folder);
  const std::string cameras = R"({"type": "tum", "file": "tum.txt", )" + kLens + "}";
  const auto making = [&](const std::string& set, std::vector<std::string> more = {}) {
    more.insert(more.end(), {"-o", set});
    const Outcome outcome = make(folder, "s.gltf", cameras, more);
    ASSERT_EQ(outcome.code, 0) << outcome.text();
  };
  making("set");
  for (const char* shard : {"0/2", "1/2"}) making("parts", {"--shard", shard});
  expectSame(filesOf(folder, "parts"), filesOf(folder, "set"));
  fs::remove(folder.path() / "parts/flow/000001.flo");
  making("parts", {"--resume"});
  expectSame(filesOf(folder, "parts"), filesOf(folder, "set"));
  // With one more pose, the last frame has a next one.
  folder.write("tum.txt", std::string_view(folder.read("tum.txt") + "3.5 0.6 0 4 1 0 0 0\n"));
  making("parts", {"--resume"});
  making("again");
  expectSame(filesOf(folder, "parts"), filesOf(folder, "again"));
}

}  // namespace
}  // namespace latelight::data
