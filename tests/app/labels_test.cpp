// `latelight render --labels`: compared with closed forms, and with the same labels in data sets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"

namespace latelight::app {
namespace {

using nlohmann::json;
using testing::ElementsAre;

// Cards that face +Z: 4 x 4 m at z = 0, and 1 x 0.5 m at z = 4.
constexpr std::string_view kCards =
    "o back\nv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3 4\n"
    "o front\nv -0.5 -0.25 4\nv 0.5 -0.25 4\nv 0.5 0.25 4\nv -0.5 0.25 4\nf 5 6 7 8\n";

// A sphere of radius 1 at the origin.
std::string sphere() {
  constexpr int kAround = 256, kAlong = 128;
  std::string text = "o ball\n";
  for (int i = 0; i <= kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      const double a = std::numbers::pi * i / kAlong, b = 2 * std::numbers::pi * j / kAround;
      text += "v " + std::to_string(std::sin(a) * std::cos(b)) + " " + std::to_string(std::cos(a)) + " " +
              std::to_string(-std::sin(a) * std::sin(b)) + "\n";
    }
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      const int next = (j + 1) % kAround, a = i * kAround + 1, b = a + kAround;
      text += "f " + std::to_string(a + j) + " " + std::to_string(b + j) + " " + std::to_string(b + next) + " " +
              std::to_string(a + next) + "\n";
    }
  return text;
}

// Decodes COCO's run lengths as its specification defines them: columns from top to bottom, groups of five bits.
std::vector<std::string> decoded(const json& segmentation) {
  const size_t height = segmentation["size"][0], width = segmentation["size"][1];
  const std::string counts = segmentation["counts"];
  std::vector<int64_t> runs;
  for (size_t at = 0; at < counts.size();) {
    int64_t value = 0;
    int bits = 0, group = 0;
    do {
      group = counts[at++] - 48;
      value |= int64_t{group & 31} << bits;
      bits += 5;
    } while ((group & 32) != 0);
    if ((group & 16) != 0) value -= int64_t{1} << bits;
    if (runs.size() > 2) value += runs[runs.size() - 2];
    runs.push_back(value);
  }
  std::vector<std::string> rows(height, std::string(width, '.'));
  size_t pixel = 0;
  for (size_t run = 0; run < runs.size(); ++run)
    for (int64_t i = 0; i < runs[run]; ++i, ++pixel) rows[pixel % height][pixel / height] = run % 2 ? '#' : '.';
  EXPECT_EQ(pixel, width * height);
  return rows;
}

class LabelsOfRender : public testing::Test {
 protected:
  json labels(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render", "--device", "cpu"});
    arguments.insert(arguments.end(), {"--labels", "labels.json"});
    return run(arguments) ? json::parse(folder.read("labels.json")) : json();
  }
  bool run(const std::vector<std::string>& arguments) const {
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return outcome.code == 0;
  }
  static const json& object(const json& labels, std::string_view node) {
    for (const json& each : labels["objects"])
      if (each["node"] == node) return each;
    throw std::logic_error("there is no object " + std::string(node));
  }
  Folder folder;
};

// The camera is 8 m in front of the large card, which covers 32 x 32 of 64 x 64 pixels, and 4 m in front of the small
// one, which covers 16 x 8.
// Lenses that hardly bend rays and rolling shutters of cameras that hardly turn change nothing.
class LabelsOfCards : public LabelsOfRender, public testing::WithParamInterface<std::vector<std::string>> {};
INSTANTIATE_TEST_SUITE_P(Cameras, LabelsOfCards,
                         testing::Values(std::vector<std::string>{"--lens=pinhole:64,64,32,32"},
                                         std::vector<std::string>{"--lens=opencv:64,64,32,32,1e-7"},
                                         std::vector<std::string>{"--lens=pinhole:64,64,32,32", "--readout=0.01",
                                                                  "--turn=1e-6"}));

TEST_P(LabelsOfCards, AreExact) {
  folder.write("cards.obj", kCards);
  folder.write("points.json", R"([{"name": "center"}, {"name": "side", "position": [1.8, 0, 0]},
                                  {"name": "behind", "position": [0, 0, 9]}])");
  std::vector<std::string> arguments{"cards.obj",      "--size=64x64", "--eye=0,0,8",
                                     "--target=0,0,0", "--keypoints",  "points.json"};
  arguments.insert(arguments.end(), GetParam().begin(), GetParam().end());
  const json all = labels(arguments);
  EXPECT_EQ(all["width"], 64);
  EXPECT_EQ(all["world"], "gltf");
  EXPECT_EQ(all["camera"]["K"], json::parse("[[64,0,32],[0,64,32],[0,0,1]]"));
  const json &back = object(all, "/cards/back"), &front = object(all, "/cards/front");
  EXPECT_EQ(back["visible"]["pixels"], 1024 - 128);
  EXPECT_EQ(back["visible"]["box"], json({16, 16, 32, 32}));
  EXPECT_EQ(back["whole"]["pixels"], 1024);
  EXPECT_EQ(back["visibleShare"], 896.0 / 1024);
  EXPECT_EQ(front["visible"]["box"], json({24, 28, 16, 8}));
  EXPECT_EQ(front["occludes"], json({{std::to_string(back["id"].get<uint32_t>()), 128}}));
  EXPECT_TRUE(back["occludes"].empty());
  const std::vector<std::string> visible = decoded(back["visible"]["segmentation"]),
                                 whole = decoded(back["whole"]["segmentation"]);
  for (size_t y = 0; y < 64; ++y)
    for (size_t x = 0; x < 64; ++x) {
      const bool isBack = x >= 16 && x < 48 && y >= 16 && y < 48, isFront = x >= 24 && x < 40 && y >= 28 && y < 36;
      ASSERT_EQ(whole[y][x] == '#', isBack) << x << ' ' << y;
      ASSERT_EQ(visible[y][x] == '#', isBack && !isFront) << x << ' ' << y;
    }
  EXPECT_EQ(back["box"]["size"], json({4, 4, 0}));
  ASSERT_EQ(back["keypoints"].size(), 3u);
  const auto expect = [](const json& keypoint, const char* name, int visibility, double x, double depth) {
    EXPECT_EQ(keypoint["name"], name);
    EXPECT_EQ(keypoint["visibility"], visibility) << name;
    EXPECT_NEAR(keypoint["pixel"][0].get<double>(), x, 1e-4) << name;
    EXPECT_NEAR(keypoint["pixel"][1].get<double>(), 32, 1e-4) << name;
    EXPECT_NEAR(keypoint["depth"].get<double>(), depth, 1e-5) << name;
  };
  expect(back["keypoints"][0], "center", 1, 32, 8);
  expect(back["keypoints"][1], "side", 2, 32 + 64 * 1.8 / 8, 8);
  EXPECT_EQ(back["keypoints"][2]["visibility"], 0);
  EXPECT_TRUE(back["keypoints"][2]["pixel"].is_null());
  EXPECT_EQ(back["keypoints"][2]["position"], json({0, 0, 9}));
}

// A sphere of radius r at the distance d is a disk of the radius f r / sqrt(d^2 - r^2).
TEST_F(LabelsOfRender, WarnOfNodesThatNoObjectHas) {
  folder.write("cards.obj", kCards);
  const auto warned = [&](const std::string& node) {
    const std::string points = R"([{"name": "point", "node": ")" + node + R"("}])";
    const Outcome outcome = latelight({.arguments = {"render", "--device", "cpu", "cards.obj", "--size=16x16",
                                                     "--labels", "labels.json", "--keypoints", points, "--id-depth=0"},
                                       .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return outcome.text().find("no object has the node \"" + node + "\" of the keypoint point") != std::string::npos;
  };
  EXPECT_TRUE(warned("bakc"));
  EXPECT_FALSE(warned("back"));
}

// The skeleton is next to the mesh "/worm". Joint i is at (0, i * 0.5 m, 0).
TEST_F(LabelsOfRender, PathsInTheSceneNameJoints) {
  const std::string points = R"([{"name": "foot", "node": "/joint 0", "thickness": 1},
                                 {"name": "knee", "node": "/joint 0/joint 1", "position": [0.1, 0, 0], "thickness": 1},
                                 {"name": "worm", "node": "/worm", "thickness": 1},
                                 {"name": "none", "node": "joint 0"},
                                 {"name": "wrong", "node": "/joint 7"}])";
  const Outcome outcome =
      latelight({.arguments = {"render", "--device", "cpu", models::modelPath("skinned.glb").string(), "--size=64x64",
                               "--eye=0,0.5,4", "--target=0,0.5,0", "--lens=pinhole:64,64,32,32", "--labels",
                               "labels.json", "--keypoints", points},
                 .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  for (const char* node : {"joint 0", "/joint 7"})
    EXPECT_THAT(outcome.text(), testing::HasSubstr("no object has the node \"" + std::string(node) + "\""));
  EXPECT_THAT(outcome.text(), testing::Not(testing::HasSubstr("no object has the node \"/joint 0")));
  const json all = json::parse(folder.read("labels.json"));
  const json& keypoints = object(all, "/worm")["keypoints"];
  ASSERT_EQ(keypoints.size(), 5u);
  const auto expect = [&](size_t i, double x, double y) {
    EXPECT_NEAR(keypoints[i]["pixel"][0].get<double>(), 32 + 16 * x, 1e-4) << i;
    EXPECT_NEAR(keypoints[i]["pixel"][1].get<double>(), 32 + 16 * (0.5 - y), 1e-4) << i;
    EXPECT_EQ(keypoints[i]["visibility"], 2) << i;
  };
  expect(0, 0, 0);
  expect(1, 0.1, 0.5);
  expect(2, 0, 0);
  for (const size_t i : {3, 4}) EXPECT_TRUE(keypoints[i]["pixel"].is_null());
}

TEST_F(LabelsOfRender, OfASphere) {
  folder.write("ball.obj", sphere());
  const json all =
      labels({"ball.obj", "--size=256x256", "--eye=0,0,4", "--target=0,0,0", "--lens=pinhole:256,256,128,128"});
  const json& ball = object(all, "/ball/ball");
  const double radius = 256 / std::sqrt(15.0);
  EXPECT_NEAR(ball["visible"]["pixels"].get<double>(), std::numbers::pi * radius * radius, 0.003 * 13726);
  EXPECT_EQ(ball["visible"]["box"], json({62, 62, 132, 132}));  // 128 -+ 66.1, by pixels whose centers are inside
  EXPECT_EQ(ball["visibleShare"], 1);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(ball["box"]["size"][axis].get<double>(), 2, 1e-3);
}

// The format "boxes" writes the same objects for the same camera, at a time of an animation, with an exposure time and
// for groups of nodes.
TEST_F(LabelsOfRender, AreThoseOfDataSets) {
  const std::string skinned = models::modelPath("skinned.glb").string();
  const std::vector<std::vector<std::string>> cases = {
      {"builtin:hall,triangles=50k,lights=12"},
      {"builtin:hall,triangles=50k,lights=12", "--id-depth=1", "--axes=z-up"},
      {skinned, "--time=0.3", "--shutter=0.02"}};
  for (const std::vector<std::string>& each : cases) {
    const std::vector<std::string> options(each.begin() + 1, each.end());
    SCOPED_TRACE(testing::PrintToString(each));
    std::vector<std::string> batch{
        "batch",        "--devices=cpu",
        "--scenes",     each[0],
        "--output=set", "--size=96x54",
        "--cameras",    R"([{"type": "list", "cameras": [{"eye": [3, 1.5, 3], "target": [0, 1, 0], "fov": 40}]}])",
        "--formats",    R"({"format": "boxes", "masks": true, "keypoints": [{"name": "origin"}]})"};
    batch.insert(batch.end(), options.begin(), options.end());
    ASSERT_TRUE(run(batch));
    std::vector<std::string> render{each[0],    "--size=96x54", "--eye=3,1.5,3",          "--target=0,1,0",
                                    "--fov=40", "--keypoints",  R"([{"name": "origin"}])"};
    render.insert(render.end(), options.begin(), options.end());
    const json own = labels(render), set = json::parse(folder.read("set/boxes/000000.json"));
    EXPECT_GT(own["objects"].size(), 0u);
    EXPECT_EQ(own["world"], set["world"]);
    ASSERT_EQ(own["objects"].size(), set["objects"].size());
    for (size_t i = 0; i < own["objects"].size(); ++i)
      for (const char* key : {"id", "node", "mesh", "materials", "visible", "whole", "visibleShare", "occludes"})
        EXPECT_EQ(own["objects"][i][key], set["objects"][i][key]) << key;
    std::filesystem::remove_all(folder.path() / "set");
  }
}

// Each frame of a sequence has its own labels, which do not change the pictures.
TEST_F(LabelsOfRender, OfSequences) {
  const std::string scene = models::modelPath("skinned.glb").string();
  const std::vector<std::string> sequence{"render",       "--device",     "cpu",      scene,
                                          "--size=64x36", "--frames=1-2", "--fps=10", "--aa=taa"};
  std::vector<std::string> plain = sequence, labeled = sequence;
  plain.insert(plain.end(), {"-o", "plain/{frame}.png"});
  labeled.insert(labeled.end(), {"-o", "labeled/{frame}.png", "--labels", "labeled/{camera}/{frame}.json"});
  ASSERT_TRUE(run(plain) && run(labeled));
  for (const char* name : {"/0001.png", "/0002.png"})
    EXPECT_TRUE(folder.read("plain" + std::string(name)) == folder.read("labeled" + std::string(name)));
  std::map<std::string, json> frames;
  for (const std::string& name : folder.names())
    if (name.ends_with(".json")) frames[std::filesystem::path(name).filename()] = json::parse(folder.read(name));
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames["0002.json"]["frame"], 2);
  EXPECT_NE(frames["0001.json"]["objects"], frames["0002.json"]["objects"]);
  EXPECT_EQ(frames["0002.json"]["objects"], labels({scene, "--size=64x36", "--time=0.2"})["objects"]);
}

TEST_F(LabelsOfRender, HaveNamesInAnyCase) {
  ASSERT_TRUE(run({"render", "--device", "cpu", "builtin:boxes", "--size=48x27", "--labels=LABELS.JSON"}));
  EXPECT_GT(json::parse(folder.read("LABELS.JSON"))["objects"].size(), 3u);
}

TEST_F(LabelsOfRender, OfAllPicturesAndWithoutOne) {
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"-o", "a.png", "--aa=ss4"},
                                             {"-o", "a.exr", "--aov=depth,id", "--aa=msaa4"},
                                             {"-o", "a.png", "--debug=depth"},
                                             {"--pick=10,10"},
                                             {"-o", "a.png", "--aperture=0.05", "--bloom=0.1"},
                                             {"-o", "a.png", "--readout=0.01", "--turn=100"}}) {
    std::vector<std::string> arguments{"builtin:boxes", "--size=48x27"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_GT(labels(arguments)["objects"].size(), 3u) << testing::PrintToString(more);
  }
  const Outcome piped = latelight({"render", "--device=cpu", "builtin:boxes", "--size=48x27", "--labels=-"});
  EXPECT_EQ(json::parse(piped.out)["objects"], labels({"builtin:boxes", "--size=48x27"})["objects"]);
}

TEST_F(LabelsOfRender, LensesAreDescribed) {
  const json all = labels({"builtin:boxes", "--size=64x48", "--lens=fisheye:20,20,32,24,0.01"});
  EXPECT_EQ(all["camera"]["model"], "fisheye");
  EXPECT_EQ(all["camera"]["distortion"][0], 0.01);
  EXPECT_GT(all["objects"].size(), 3u);
}

}  // namespace
}  // namespace latelight::app
