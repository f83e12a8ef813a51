// The format `correspondence`: a square at z = 0 fills the pictures of cameras at z = 4 with a focal length of 40
// pixels, so its points are 10 d pixels further left in a camera that is d meters further right.
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
using testing::HasSubstr;

constexpr size_t kPixels = 32 * 24;

void writeSquare(const Folder& folder) {
  const float positions[] = {-40, -40, 0, 40, -40, 0, 40, 40, 0, -40, 40, 0};
  const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  std::string buffer(reinterpret_cast<const char*>(positions), sizeof(positions));
  buffer.append(reinterpret_cast<const char*>(indices), sizeof(indices));
  folder.write("square.bin", std::string_view(buffer));
  folder.write("square.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "square", "mesh": 0}], "buffers": [{"uri": "square.bin", "byteLength": 60}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-40, -40, 0],
      "max": [40, 40, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]})"));
}

json poseAt(double x) {
  return json::array({{1, 0, 0, x}, {0, -1, 0, 0}, {0, 0, -1, 4}, {0, 0, 0, 1}});
}

// Key frames at x = 0, 1, 2 and so on, which are the frames of the path.
json path(int count, double step = 1) {
  json keys = json::array();
  for (int i = 0; i < count; ++i) keys.push_back({{"pose", poseAt(step * i)}});
  return {{"type", "path"}, {"count", count}, {"keys", keys}, {"fov", 2 * std::atan(12.0 / 40) * 180 / M_PI}};
}

Outcome makePairs(const Folder& folder, const json& cameras, const json& formats, std::vector<std::string> more = {}) {
  folder.write("job.json", std::string_view(json{{"cameras", cameras}, {"formats", formats}}.dump()));
  std::vector<std::string> all{"job.json", "--scenes", "square.gltf"};
  if (std::ranges::find(more, "-o") == more.end()) all.insert(all.end(), {"-o", "set"});
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

// The values of an NPY file of floats, version 1.0.
std::vector<float> floatsIn(const std::string& npy) {
  const size_t begin = 10 + static_cast<uint8_t>(npy.at(8)) + 256 * static_cast<uint8_t>(npy.at(9));
  std::vector<float> values((npy.size() - begin) / sizeof(float));
  std::memcpy(values.data(), npy.data() + begin, values.size() * sizeof(float));
  return values;
}

// Returns how far the points of a pair are moved to the right, which is equal at all pixels.
double shiftIn(const Folder& folder, const std::string& file) {
  const std::vector<float> pixels = floatsIn(folder.read(file));
  EXPECT_EQ(pixels.size(), 2 * kPixels) << file;
  for (size_t i = 0; i < pixels.size() / 2; ++i) {
    EXPECT_NEAR(pixels[2 * i] - double(i % 32) - 0.5, pixels[0] - 0.5, 2e-3) << file;
    EXPECT_NEAR(pixels[2 * i + 1], double(i / 32) + 0.5, 2e-3) << file;
  }
  return pixels[0] - 0.5;
}

// The number of frames that the last run of a set rendered.
std::string lastCount(const Folder& folder, const std::string& set) {
  const std::string log = folder.read(set + "/.latelight/log");
  return log.substr(log.rfind("begins: ") + 8, 6);
}

TEST(Correspondence, LeadsToFramesOfTheSequence) {
  Folder folder;
  writeSquare(folder);
  const json format{{"format", "correspondence"}, {"as", "npy"}, {"to", {"next", "previous", 2}}};
  const Outcome outcome = makePairs(folder, path(4), json::array({format}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const std::string first = "set/correspondence/00000";
  for (int i = 0; i < 4; ++i) {
    const std::string name = first + std::to_string(i);
    EXPECT_EQ(fs::exists(folder.at(name + ".next.pixels.npy")), i < 3);
    EXPECT_EQ(fs::exists(folder.at(name + ".previous.pixels.npy")), i > 0);
    EXPECT_EQ(fs::exists(folder.at(name + ".+2.pixels.npy")), i < 2);
    if (i < 3) {
      EXPECT_NEAR(shiftIn(folder, name + ".next.pixels.npy"), -10, 2e-3);
    }
    if (i > 0) {
      EXPECT_NEAR(shiftIn(folder, name + ".previous.pixels.npy"), 10, 2e-3);
    }
    if (i < 2) {
      EXPECT_NEAR(shiftIn(folder, name + ".+2.pixels.npy"), -20, 2e-3);
    }
  }
  for (const float depth : floatsIn(folder.read(first + "0.next.depth.npy"))) EXPECT_NEAR(depth, 4, 1e-5);
  for (const float flow : floatsIn(folder.read(first + "0.next.flow.npy"))) EXPECT_EQ(flow, 0);
  // Points that leave the second picture on the left are not visible there.
  const std::string visible = folder.read(first + "0.+2.visible.npy");
  for (size_t i = 0; i < kPixels; ++i) EXPECT_EQ(visible.at(visible.size() - kPixels + i), i % 32 >= 20);
  const json pairs = json::parse(folder.read("set/correspondence/pairs.json")).at("pairs");
  ASSERT_EQ(pairs.size(), 3u + 3 + 2);
  EXPECT_EQ(pairs[0], json({{"first", "000000"},
                            {"to", "next"},
                            {"second", "000001"},
                            {"time", nullptr},
                            {"file", "correspondence/000000.next.npy"}}));
}

TEST(Correspondence, LeadsToCamerasAndMembersOfRigs) {
  Folder folder;
  writeSquare(folder);
  const json stereo{{"type", "stereo"}, {"baseline", 0.5}, {"cameras", path(2)}};
  const json format{
      {"format", "correspondence"}, {"as", "npy"}, {"to", {{{"member", "right"}}, {{"camera", "path0-left"}}}}};
  const Outcome outcome = makePairs(folder, stereo, json::array({format}), {"--name", "{camera}"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const std::string set = "set/correspondence/";
  EXPECT_NEAR(shiftIn(folder, set + "path0-left.right.pixels.npy"), -5, 2e-3);
  EXPECT_NEAR(shiftIn(folder, set + "path1-left.right.pixels.npy"), -5, 2e-3);
  EXPECT_NEAR(shiftIn(folder, set + "path1-right.path0-left.pixels.npy"), 15, 2e-3);
  EXPECT_FALSE(fs::exists(folder.at(set + "path0-right.right.pixels.npy")));
  EXPECT_FALSE(fs::exists(folder.at(set + "path0-left.path0-left.pixels.npy")));
  const Outcome wrong =
      makePairs(folder, stereo, {{{"format", "correspondence"}, {"to", {{"camera", "middle"}}}}}, {"-o", "other"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("leads to the camera \"middle\", but the scene has no such camera"));
  const Outcome misspelled =
      makePairs(folder, stereo, {{{"format", "correspondence"}, {"to", {{"member", "rigth"}}}}}, {"-o", "other"});
  EXPECT_EQ(misspelled.code, 2);
  EXPECT_THAT(misspelled.err, HasSubstr("leads to the member \"rigth\", but no rig of the cameras has such a member"));
}

TEST(Correspondence, ShardsAndResumedSetsAreTheSame) {
  Folder folder;
  writeSquare(folder);
  const json formats = {{{"format", "correspondence"}, {"to", {"next", -2}}},
                        {{"format", "correspondence"}, {"as", "exr"}, {"pairs", "pairs.json"}}};
  ASSERT_EQ(makePairs(folder, path(5), formats).code, 0);
  for (const char* shard : {"0/2", "1/2"}) {
    const Outcome part = makePairs(folder, path(5), formats, {"-o", "parts", "--shard", shard});
    ASSERT_EQ(part.code, 0) << part.text();
  }
  expectSame(filesOf(folder, "parts"), filesOf(folder, "set"));
  // A frame whose pair changes is rendered again: all lead to the camera that moves first.
  json cameras = path(5);
  cameras = {{"type", "list"}, {"cameras", json::array()}, {"fov", cameras["fov"]}};
  for (int i = 0; i < 3; ++i) cameras["cameras"].push_back({{"name", fmt::format("c{}", i)}, {"pose", poseAt(i)}});
  const json toLast = {{{"format", "correspondence"}, {"to", {{"camera", "c2"}}}}};
  ASSERT_EQ(makePairs(folder, cameras, toLast, {"-o", "list"}).code, 0);
  cameras["cameras"][2]["pose"] = poseAt(3);
  ASSERT_EQ(makePairs(folder, cameras, toLast, {"-o", "list", "--resume"}).code, 0);
  EXPECT_EQ(lastCount(folder, "list"), "3 of 3");
  cameras["cameras"][1]["pose"] = poseAt(1.5);
  ASSERT_EQ(makePairs(folder, cameras, toLast, {"-o", "list", "--resume"}).code, 0);
  EXPECT_EQ(lastCount(folder, "list"), "1 of 3");
  ASSERT_EQ(makePairs(folder, cameras, toLast, {"-o", "again"}).code, 0);
  expectSame(filesOf(folder, "list"), filesOf(folder, "again"));
}

TEST(Correspondence, WrongTargetsAreNamed) {
  Folder folder;
  writeSquare(folder);
  for (const json& to : {json(0), json("nearest"), json::array(), json({{"camera", 3}}), json({{"lens", "a"}})}) {
    const Outcome outcome = makePairs(folder, path(2), {{{"format", "correspondence"}, {"to", to}}});
    EXPECT_EQ(outcome.code, 2) << to;
    EXPECT_THAT(outcome.err, HasSubstr("to of the format correspondence takes")) << to;
  }
  const json twice{{"format", "correspondence"}, {"to", {"next", 1}}};
  EXPECT_THAT(makePairs(folder, path(2), json::array({twice})).err, HasSubstr("has \"next\" twice"));
  const json oneFile{{"format", "correspondence"}, {"to", {"next", 2}}, {"file", "{name}.npz"}};
  EXPECT_THAT(makePairs(folder, path(2), json::array({oneFile})).err, HasSubstr("needs {to} in it"));
}

}  // namespace
}  // namespace latelight::data
