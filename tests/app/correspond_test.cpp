// `latelight render --correspond`: compared with closed forms, and with the same pairs in data sets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"
#include "output/read.h"

namespace latelight::app {
namespace {

using nlohmann::json;

// Cards that face +Z: 4 x 4 m at z = 0, and 1 x 0.5 m at z = 4.
constexpr std::string_view kCards =
    "o back\nv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3 4\n"
    "o front\nv -0.5 -0.25 4\nv 0.5 -0.25 4\nv 0.5 0.25 4\nv -0.5 0.25 4\nf 5 6 7 8\n";

// A square at z = 0 that moves by 1 m/s along X for 2 s, and the cameras "left" and "right", which are 0.5 m apart at
// z = 4 and whose focal length is 40 pixels of 32 x 24. The square fills their pictures.
void writeMoving(const Folder& folder) {
  const float positions[] = {-40, -40, 0, 40, -40, 0, 40, 40, 0, -40, 40, 0}, times[] = {0, 2},
              translations[] = {0, 0, 0, 2, 0, 0};
  const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  std::string buffer;
  const auto append = [&](const auto& values) { buffer.append(reinterpret_cast<const char*>(values), sizeof(values)); };
  append(positions);
  append(times);
  append(translations);
  append(indices);
  folder.write("moving.bin", std::string_view(buffer));
  json gltf = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
    "nodes": [{"name": "square", "mesh": 0}, {"name": "left", "camera": 0, "translation": [0, 0, 4]},
      {"name": "right", "camera": 1, "translation": [0.5, 0, 4]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 3}]}],
    "animations": [{"samplers": [{"input": 1, "output": 2}],
      "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
    "buffers": [{"uri": "moving.bin", "byteLength": 92}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 8},
      {"buffer": 0, "byteOffset": 56, "byteLength": 24}, {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-40, -40, 0],
      "max": [40, 40, 0]}, {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0],
      "max": [2]}, {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
      {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}]})");
  for (const char* name : {"left", "right"})
    gltf["cameras"].push_back(
        {{"name", name},
         {"type", "perspective"},
         {"perspective",
          {{"yfov", 2 * std::atan(12.0 / 40)}, {"aspectRatio", 4.0 / 3}, {"znear", 0.1}, {"zfar", 100}}}});
  folder.write("moving.gltf", std::string_view(gltf.dump()));
}

struct Match {
  std::vector<float> pixels, depth, flow;
  std::vector<uint8_t> visible;
};

// Reads an array of an NPZ file without compression. Its first mention is the local header, which the array follows.
template <typename Value>
std::vector<Value> arrayIn(const std::string& npz, const std::string& name, size_t count) {
  const auto sizeAt = [&](size_t at) {
    return static_cast<uint8_t>(npz.at(at)) + 256 * static_cast<uint8_t>(npz.at(at + 1));
  };
  const size_t at = npz.find(name + ".npy");
  if (at == std::string::npos) throw std::runtime_error("there is no array " + name);
  const size_t npy = at + name.size() + 4 + sizeAt(at - 2), begin = npy + 10 + sizeAt(npy + 8);
  std::vector<Value> values(count);
  std::memcpy(values.data(), npz.substr(begin, count * sizeof(Value)).data(), count * sizeof(Value));
  return values;
}

class CorrespondOfRender : public testing::Test {
 protected:
  bool run(const std::vector<std::string>& arguments) const {
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return outcome.code == 0;
  }
  bool render(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render", "--device", "cpu"});
    return run(arguments);
  }
  Match read(const std::string& file, size_t count) const {
    const std::string npz = folder.read(file);
    return {arrayIn<float>(npz, "pixels", 2 * count), arrayIn<float>(npz, "depth", count),
            arrayIn<float>(npz, "flow", 3 * count), arrayIn<uint8_t>(npz, "visible", count)};
  }
  // Expects that all points of the square are `shift` pixels further right, and have moved by `meters`.
  void expectShift(const std::string& file, double shift, double meters) const {
    SCOPED_TRACE(file);
    const Match match = read(file, 32 * 24);
    for (size_t i = 0; i < 32 * 24; ++i) {
      const double x = double(i % 32) + 0.5 + shift;
      ASSERT_NEAR(match.pixels[2 * i], x, 2e-3);
      ASSERT_NEAR(match.pixels[2 * i + 1], double(i / 32) + 0.5, 2e-3);
      ASSERT_NEAR(match.depth[i], 4, 1e-5);
      ASSERT_NEAR(match.flow[3 * i], meters, 1e-5);
      ASSERT_NEAR(match.flow[3 * i + 1], 0, 1e-5);
      if (std::abs(x) < 0.01 || std::abs(x - 32) < 0.01) continue;  // on the edge of the second picture
      ASSERT_EQ(match.visible[i], x > 0 && x < 32);
    }
  }
  Folder folder;
};

// A camera that shifts by b parallel to a plane at the distance z sees its points f b / z further left: the large card
// at 8 m by 4 pixels, the small one at 4 m by 8, so that it occludes 4 columns that the first picture shows.
class CorrespondOfCards : public CorrespondOfRender, public testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(Lenses, CorrespondOfCards, testing::Values("pinhole:64,64,32,32", "opencv:64,64,32,32,1e-7"));

TEST_P(CorrespondOfCards, IsDisparity) {
  folder.write("cards.obj", kCards);
  const std::vector<std::string> options{"cards.obj",          "--size=64x64",        "--eye=0,0,8",
                                         "--target=0,0,0",     "--to-eye=0.5,0,8",    "--to-target=0.5,0,0",
                                         "--correspond=a.npz", "--lens=" + GetParam()};
  ASSERT_TRUE(render(options));
  const Match match = read("a.npz", 64 * 64);
  for (size_t i = 0; i < 64 * 64; ++i) {
    const size_t x = i % 64, y = i / 64;
    SCOPED_TRACE(fmt::format("{} {}", x, y));
    const bool isBack = x >= 16 && x < 48 && y >= 16 && y < 48, isFront = x >= 24 && x < 40 && y >= 28 && y < 36;
    ASSERT_EQ(std::isnan(match.pixels[2 * i]), !isBack);
    ASSERT_EQ(std::isnan(match.depth[i]), !isBack);
    ASSERT_EQ(match.visible[i], isBack && (isFront || x < 20 || x >= 24 || y < 28 || y >= 36));
    for (size_t k = 0; k < 3; ++k) ASSERT_EQ(match.flow[3 * i + k], 0);
    if (!isBack) continue;
    ASSERT_NEAR(match.pixels[2 * i], double(x) + 0.5 - (isFront ? 8 : 4), 2e-3);
    ASSERT_NEAR(match.pixels[2 * i + 1], double(y) + 0.5, 2e-3);
    ASSERT_NEAR(match.depth[i], isFront ? 4 : 8, 1e-4);
  }
}

TEST_F(CorrespondOfRender, LeadsToCamerasAndTimes) {
  writeMoving(folder);
  const auto expect = [&](std::vector<std::string> options, double shift, double meters) {
    SCOPED_TRACE(testing::PrintToString(options));
    options.insert(options.begin(), {"moving.gltf", "--size=32x24", "--fps=4", "--correspond=a.npz"});
    ASSERT_TRUE(render(options));
    expectShift("a.npz", shift, meters);
  };
  expect({"--to-camera=right"}, -5, 0);
  expect({"--camera=right", "--to-camera=0"}, 5, 0);
  expect({"--time=0.5"}, 2.5, 0.25);
  expect({"--time=0.5", "--to=previous"}, -2.5, -0.25);
  expect({"--time=0.5", "--to=+4"}, 10, 1);
  expect({"--time=0.5", "--to=-2"}, -5, -0.5);
  expect({"--time=0.5", "--to-time=0.125"}, -3.75, -0.375);
  expect({"--time=0.5", "--to-camera=right"}, -5, 0);
  expect({"--time=0.5", "--to-camera=right", "--to=next"}, -2.5, 0.25);
  expect({"--time=0.5", "--to-camera=right", "--to-time=1.5"}, 5, 1);
  expect({"--camera=left", "--to-eye=-0.5,0,4", "--to-target=-0.5,0,0", "--fov=33.3984885"}, 5, 0);
}

// Each frame of a sequence has its own file, also the last one, and no picture changes.
TEST_F(CorrespondOfRender, OfSequences) {
  writeMoving(folder);
  const std::vector<std::string> sequence{"moving.gltf", "--size=32x24", "--frames=1-3", "--fps=4", "--aa=taa"};
  std::vector<std::string> plain = sequence, matched = sequence, key = sequence;
  plain.insert(plain.end(), {"-o", "plain/{frame}.png"});
  matched.insert(matched.end(), {"-o", "matched/{frame}.png", "--correspond", "matched/{camera}/{frame}.npz"});
  key.insert(key.end(), {"--correspond", "key/{frame}.npz", "--to-time=0.5"});
  ASSERT_TRUE(render(plain) && render(matched) && render(key));
  for (int frame = 1; frame <= 3; ++frame) {
    const std::string name = fmt::format("/{:04}", frame);
    EXPECT_FALSE(folder.read("plain" + name + ".png").empty());
    EXPECT_TRUE(folder.read("plain" + name + ".png") == folder.read("matched" + name + ".png"));
    expectShift("matched/left" + name + ".npz", 2.5, 0.25);
    expectShift("key" + name + ".npz", 10 * (0.5 - frame / 4.0), 0.5 - frame / 4.0);
  }
}

// The format "correspondence" writes the same bytes for the same pair.
TEST_F(CorrespondOfRender, IsThatOfDataSets) {
  const std::string skinned = models::modelPath("skinned.glb").string();
  struct Case {
    std::string scene, to;
    std::vector<std::string> common, second;
  };
  const std::vector<std::string> toOther{"--to-eye=2,1.2,3.5", "--to-target=0,1,0.2"};
  const std::vector<Case> cases = {
      {"builtin:hall,triangles=50k,lights=12", R"({"camera": "b"})", {"--axes=z-up"}, toOther},
      {skinned, R"("next")", {"--time=0.3", "--fps=10"}, {}},
      {skinned, R"("previous")", {"--time=0.3", "--fps=10", "--raster=compute", "--shutter=0.02"}, {"--to=previous"}}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.scene + each.to);
    std::vector<std::string> batch{
        "batch",
        "--devices=cpu",
        "--scenes",
        each.scene,
        "--output=set",
        "--size=96x54",
        "--name={camera}",
        "--cameras",
        R"([{"type": "list", "fov": 40, "cameras": [{"name": "a", "eye": [3, 1.5, 3], "target": [0, 1, 0]},
            {"name": "b", "eye": [2, 1.2, 3.5], "target": [0, 1, 0.2]}]}])",
        "--formats",
        R"([{"format": "correspondence", "file": "a/{name}.npz", "pairs": "a.json", "to": )" + each.to +
            R"(}, {"format": "correspondence", "as": "exr", "file": "a/{name}.exr", "pairs": "b.json", "to": )" +
            each.to + "}]"};
    batch.insert(batch.end(), each.common.begin(), each.common.end());
    ASSERT_TRUE(run(batch));
    std::vector<std::string> options{each.scene, "--size=96x54", "--eye=3,1.5,3", "--target=0,1,0", "--fov=40"};
    options.insert(options.end(), each.common.begin(), each.common.end());
    options.insert(options.end(), each.second.begin(), each.second.end());
    for (const char* file : {"OWN.NPZ", "OWN.EXR"}) {
      std::vector<std::string> one = options;
      one.insert(one.end(), {"--correspond", file});
      ASSERT_TRUE(render(one));
    }
    const std::string set = folder.read("set/a/a.npz");
    EXPECT_GT(set.size(), 96u * 54 * 25);
    EXPECT_TRUE(folder.read("OWN.NPZ") == set);
    const output::ReadImage own = output::readImage(folder.at("OWN.EXR")),
                            image = output::readImage(folder.at("set/a/a.exr"));
    ASSERT_EQ(own.channels.size(), 7u);
    for (const output::Channel& channel : own.channels) {
      const output::Channel* other = image.find(channel.name);
      ASSERT_TRUE(other) << channel.name;
      EXPECT_EQ(std::memcmp(channel.values.data(), other->values.data(), 96 * 54 * sizeof(double)), 0) << channel.name;
    }
    std::filesystem::remove_all(folder.path() / "set");
  }
}

TEST_F(CorrespondOfRender, WithAllPictures) {
  const std::vector<std::string> common{"builtin:boxes",    "--size=48x27",      "--eye=4,2.5,8",     "--target=0,1,0",
                                        "--to-eye=3,2.5,8", "--to-target=0,1,0", "--correspond=a.npz"};
  ASSERT_TRUE(render(common));
  const std::string alone = folder.read("a.npz");
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"-o", "a.png", "--aa=ss4"},
                                             {"-o", "a.exr", "--aov=depth,id", "--aa=msaa4"},
                                             {"-o", "a.png", "--debug=depth", "--labels=a.json"},
                                             {"--pick=10,10"},
                                             {"-o", "a.png", "--aperture=0.05", "--bloom=0.1"},
                                             {"-o", "a.png", "--readout=0.01", "--turn=0"}}) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_TRUE(render(arguments)) << testing::PrintToString(more);
    EXPECT_TRUE(folder.read("a.npz") == alone) << testing::PrintToString(more);
  }
}

TEST_F(CorrespondOfRender, IsInTheReport) {
  const Outcome outcome = latelight({.arguments = {"render", "--device=cpu", "builtin:boxes", "--size=16x9", "--time=0",
                                                   "--correspond=a.npz", "--json"},
                                     .folder = folder.path()});
  EXPECT_EQ(json::parse(outcome.out)["files"], json({"a.npz"})) << outcome.text();
}

}  // namespace
}  // namespace latelight::app
