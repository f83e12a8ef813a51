// Invalid jobs: each ends with one sentence that names the key.
#include <fmt/format.h>
#include <latelight/latelight.h>

#include <chrono>

#include "base/memory.h"
#include "data/cameras/tum.h"
#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

struct Wrong {
  const char* spec;
  const char* says;
};

class WrongTest : public testing::TestWithParam<Wrong> {};

TEST_P(WrongTest, IsNamed) {
  const std::string sentence = errorOf([] { made(GetParam().spec); });
  EXPECT_THAT(sentence, testing::HasSubstr(GetParam().says));
  EXPECT_EQ(sentence.find('\n'), std::string::npos);
}

constexpr Wrong kWrong[] = {
    {R"(3)", "cameras must be an object, not 3"},
    {R"([])", "cameras is an empty list"},
    {R"({})", "cameras needs \"type\""},
    {R"([{"type": "scene"}, {"type": "spiral"}])", "cameras[1].type must be one of scene, list, orbit"},
    {R"({"type": 7})", "cameras.type must be a string, not 7"},
    {R"({"type": "scene", "name": "x"})",
     "cameras has the unknown key \"name\": the keys are EV, ISO, fNumber, names, noiseSeed, readout, shutter, type"},
    {R"({"type": "scene", "names": ["x"]})", "has no camera \"x\""},
    {R"({"type": "orbit"})", "cameras needs \"count\""},
    {R"({"type": "orbit", "count": 0})", "cameras.count must be a whole number from 1 to 1000000, not 0"},
    {R"({"type": "orbit", "count": 2.5})", "cameras.count must be a whole number"},
    {R"({"type": "orbit", "count": -3})", "cameras.count must be a whole number"},
    {R"({"type": "orbit", "count": 3, "distance": -1})", "cameras.distance must be a number above 0, not -1"},
    {R"({"type": "orbit", "count": 3, "distance": [2, 1]})", "cameras.distance must list the minimum first"},
    {R"({"type": "orbit", "count": 3, "elevation": 91})", "cameras.elevation must be a number from -90 to 90, not 91"},
    {R"({"type": "orbit", "count": 3, "target": "car"})", "cameras.target must be \"scene\", a point"},
    {R"({"type": "orbit", "count": 3, "target": {"node": "car"}})", "cameras.target.node: builtin:boxes has no node"},
    {R"({"type": "orbit", "count": 3, "target": [0, 0]})", "cameras.target must be a list of 3 numbers"},
    {R"({"type": "orbit", "count": 3, "target": [0, 0, 0]})", "cameras requires \"distance\""},
    {R"({"type": "orbit", "count": 3, "target": [0, 0, "a"]})", "cameras.target[2] must be a number, not \"a\""},
    {R"({"type": "orbit", "count": 3, "distance": 1e300})", "cameras.distance must not exceed 1e+15, but is 1e+300"},
    {R"({"type": "orbit", "count": 3, "fov": 180})", "cameras.fov must be a number from 1e-07 to 179.999, not 180"},
    {R"({"type": "orbit", "count": 3, "size": [0, 4]})", "cameras.size[0] must be a number from 1 to 65536, not 0"},
    {R"({"type": "orbit", "count": 3, "size": [2.5, 4]})", "cameras.size must be whole numbers"},
    {R"({"type": "list", "cameras": []})", "cameras.cameras must be a list of objects"},
    {R"({"type": "list", "cameras": [{"name": "a"}]})", "cameras.cameras[0] needs either \"eye\" or \"pose\""},
    {R"({"type": "list", "cameras": [{"eye": [0, 0, 0], "target": [0, 0, 0]}]})", "eye and its target at the same"},
    {R"({"type": "list", "cameras": [{"eye": [0, 1, 0], "target": [0, 0, 0], "up": [0, 1, 0]}]})",
     "cameras.cameras[0].up is zero or parallel to the view"},
    {R"({"type": "list", "cameras": [{"pose": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})",
     "cameras.cameras[0].pose must be a rotation and a translation"},
    {R"({"type": "list", "cameras": [{"pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}]})",
     "cameras.cameras[0].pose must be a list of 4 rows of 4 numbers"},
    {R"({"type": "list", "K": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "cameras": [{"eye": [0, 0, 1]}]})",
     "cameras needs \"size\""},
    {R"({"type": "list", "K": [[1, 3, 0], [0, 1, 0], [0, 0, 1]], "size": [4, 4], "cameras": [{"eye": [0, 0, 1]}]})",
     "cameras.K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"},
    {R"({"type": "list", "distortion": [1], "K": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "size": [4, 4], "cameras": []})",
     "cameras.distortion needs the model opencv, fisheye or ftheta"},
    {R"({"type": "orbit", "count": 2, "distortion": [0.1]})",
     "cameras.distortion needs the model opencv, fisheye or ftheta"},
    {R"({"type": "orbit", "count": 2, "pixelCenter": 0})", "cameras.pixelCenter needs \"K\""},
    {R"({"type": "list", "model": "cubemap", "fov": 3, "cameras": []})",
     "cameras.fov requires the model pinhole without K"},
    {R"({"type": "box", "count": 1, "min": [1, 0, 0], "max": [0, 0, 0]})", "cameras.min must be at most cameras.max"},
    {R"({"type": "box", "count": 1, "min": [1, 0, 0]})", "cameras needs \"max\""},
    {R"({"type": "box", "count": 1, "rejectInside": 1})", "cameras.rejectInside must be true or false, not 1"},
    {R"({"type": "box", "count": 1, "min": [0, -0.5, 0], "max": [0.1, -0.4, 0.1]})",
     "found places for 0 of 1 cameras only"},
    {R"({"type": "sphere", "count": 3, "radius": 0.1, "target": [0, -0.5, 0]})", "no point of the sphere is free"},
    {R"({"type": "path", "count": 3, "keys": [{"eye": [0, 0, 1]}]})", "cameras.keys must have at least two key frames"},
    {R"({"type": "path", "count": 3, "keys": [{"eye": [0, 0, 1]}, {"time": 1, "eye": [0, 0, 1]}]})",
     "cameras.keys must have a time in all keyframes or in none"},
    {R"({"type": "path", "count": 3, "keys": [{"time": 1, "eye": [0, 0, 1]}, {"time": 1, "eye": [0, 0, 1]}]})",
     "cameras.keys[1].time must be later"},
    {R"({"type": "path", "keys": [{"eye": [0, 0, 1]}, {"eye": [0, 0, 2]}]})",
     "cameras needs either \"count\" or \"fps\""},
    {R"({"type": "path", "fps": 1e9, "keys": [{"eye": [0, 0, 1]}, {"eye": [0, 0, 2]}]})",
     "cameras.fps gives more than 1000000 cameras"},
    {R"({"type": "path", "count": 3, "keys": [{"eye": [0, 0, 1], "fov": 40, "size": [8, 8]}, {"eye": [0, 0, 2]}]})",
     "cameras.keys[0] has the unknown key \"size\": the keys are eye, fov, frame, pose, target, time, up"},
    {R"({"type": "list", "cameras": [{"eye": [0, 0, 1], "frame": "opengl"}]})",
     "cameras.cameras[0].frame is the camera frame of \"pose\""},
    {R"({"type": "rig", "offsets": [{"name": "a"}], "cameras": {"type": "scene"}})",
     "cameras.offsets[0] needs \"translation\""},
    {R"({"type": "stereo", "baseline": 1, "cameras": {"type": "nothing"}})", "cameras.cameras.type must be one of"},
    {R"({"type": "bop", "file": "x.json"})", "cameras needs \"size\""},
};
INSTANTIATE_TEST_SUITE_P(Jobs, WrongTest, testing::ValuesIn(kWrong));

TEST(MissingFileTest, IsNamed) {
  for (const char* spec :
       {R"({"type": "transforms", "file": "/nowhere/t.json"})", R"({"type": "tum", "file": "/nowhere/t.txt"})",
        R"({"type": "bop", "file": "/nowhere/t.json", "size": [4, 4]})",
        R"({"type": "colmap", "folder": "/nowhere/sparse"})"})
    EXPECT_THAT(errorOf([&] { made(spec); }, ExitCode::BadInput), testing::HasSubstr("/nowhere/"));
}

TEST(EmptySceneTest, SaysThatThereIsNothing) {
  scene::Scene empty;
  empty.source = "empty.glb";
  EXPECT_THAT(errorOf([&] { made(R"({"type": "orbit", "count": 1})", empty); }),
              testing::HasSubstr("nothing to be seen in empty.glb"));
  EXPECT_THAT(errorOf([&] { made("null", empty); }), testing::HasSubstr("has no cameras of its own"));
  EXPECT_EQ(
      made(R"({"type": "box", "count": 3, "min": [0, 0, 0], "max": [1, 1, 1], "target": "random"})", empty).size(), 3u);
}

// Pairs and rigs multiply cameras, and sources add up. The total is known before any camera is created.
TEST(CameraBounds, TooManyCamerasAreRefusedAtOnce) {
  const auto pairs = [](int count) {
    std::string spec = R"({"type": "orbit", "count": 1})";
    for (int i = 0; i < count; ++i) spec = R"({"type": "stereo", "baseline": 1, "cameras": )" + spec + "}";
    return spec;
  };
  std::string rig = R"({"type": "orbit", "count": 10000})";
  for (const char* stem : {"a", "b"}) {
    std::string members;
    for (int i = 0; i < 100; ++i)
      members += fmt::format(R"({}{{"name": "{}{}", "translation": [0, 0, 0]}})", i ? "," : "", stem, i);
    rig = R"({"type": "rig", "offsets": [)" + members + R"(], "cameras": )" + rig + "}";
  }
  std::string sources = "[";
  for (int i = 0; i < 50; ++i) sources += std::string(i ? "," : "") + R"({"type": "orbit", "count": 1000000})";
  const auto start = std::chrono::steady_clock::now();
  for (const std::string& spec : {pairs(30), pairs(60), rig, sources + "]"})
    EXPECT_THAT(errorOf([&] { made(spec); }), testing::HasSubstr("at most 10000000"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  EXPECT_EQ(made(pairs(10)).size(), 1024u);
}

// Cameras count towards --memory, as do the names that members add.
TEST(CameraBounds, CamerasAreClaimedBeforeTheyAreMade) {
  const uint64_t before = memoryLimit();
  setMemoryLimit(64 << 20);
  const std::string many = errorOf([] { made(R"({"type": "orbit", "count": 1000000})"); }, ExitCode::OutOfMemory);
  const std::string named = errorOf(
      [] {
        made(R"({"type": "rig", "cameras": {"type": "orbit", "count": 2000}, "offsets": [{"name": ")" +
             std::string(100'000, 'n') + R"(", "translation": [0, 0, 0]}]})");
      },
      ExitCode::OutOfMemory);
  const size_t few = made(R"({"type": "orbit", "count": 1000})").size();
  setMemoryLimit(before);
  EXPECT_THAT(many, testing::HasSubstr("there is no memory for the"));
  EXPECT_THAT(named, testing::HasSubstr("there is no memory for the"));
  EXPECT_EQ(few, 1000u);
}

// A camera needs more memory than its description in a file: a line of 16 bytes becomes some 400 bytes.
TEST(CameraBounds, CamerasOfFilesAreClaimed) {
  const Folder folder;
  std::string lines;
  for (int i = 0; i < 200'000; ++i) lines += "0 0 0 0 0 0 0 1\n";
  folder.write("t.txt", lines);
  const uint64_t before = memoryLimit();
  setMemoryLimit(32 << 20);
  const std::string sentence = errorOf([&] { readTum(folder.at("t.txt")); }, ExitCode::OutOfMemory);
  setMemoryLimit(before);
  EXPECT_THAT(sentence, testing::HasSubstr("there is no memory for the cameras of a file"));
  EXPECT_EQ(readTum(folder.at("t.txt")).size(), 200'000u);
}

}  // namespace
}  // namespace latelight::data::test
