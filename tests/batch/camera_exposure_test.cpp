// Exposure time, readout and noise of single cameras of a job: their frames equal those of a set whose options have
// these values.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using nlohmann::json;
using testing::HasSubstr;

json orbit(const json& more = json::object()) {
  json camera{{"type", "orbit"}, {"count", 4}};
  camera.update(more);
  return camera;
}

Outcome makeExposed(const Folder& folder, const std::string& set, const json& cameras,
                    const std::vector<std::string>& more = {}) {
  json job{{"cameras", cameras}, {"options", {{"fps", 24}, {"camera-samples", 4}}}};
  folder.write("job.json", std::string_view(job.dump()));
  std::vector<std::string> all{"job.json", "--scenes", "builtin:boxes", "-o", set};
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

TEST(CameraExposure, FramesEqualThoseOfASetWithTheOptions) {
  Folder folder;
  const json cameras = {orbit({{"shutter", 0.04}}), orbit({{"readout", 0.03}}), orbit(), orbit({{"shutter", 0.01}})};
  const Outcome outcome = makeExposed(folder, "set", cameras);
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json plain = {orbit(), orbit(), orbit(), orbit()};
  ASSERT_EQ(makeExposed(folder, "still", plain).code, 0);
  ASSERT_EQ(makeExposed(folder, "long", plain, {"--shutter", "0.04"}).code, 0);
  ASSERT_EQ(makeExposed(folder, "rows", plain, {"--readout", "0.03"}).code, 0);
  ASSERT_EQ(makeExposed(folder, "short", plain, {"--shutter", "0.01"}).code, 0);
  const std::map<std::string, std::string> set = filesOf(folder, "set"), still = filesOf(folder, "still");
  const char* others[] = {"long", "rows", "still", "short"};
  for (size_t i = 0; i < 16; ++i) {
    const std::string name = fmt::format("{:06}.png", i);
    EXPECT_TRUE(set.at(name) == filesOf(folder, others[i / 4]).at(name)) << name;
    EXPECT_EQ(set.at(name) == still.at(name), i / 4 == 2) << name;
  }
}

TEST(CameraExposure, MembersOfRigsDiffer) {
  Folder folder;
  const json rig{
      {"type", "rig"},
      {"readout", 0.03},
      {"cameras", orbit()},
      {"offsets",
       {{{"name", "a"}, {"translation", {0, 0, 0}}, {"readout", 0}}, {{"name", "b"}, {"translation", {0.1, 0, 0}}}}}};
  ASSERT_EQ(makeExposed(folder, "set", rig, {"--name", "{camera}"}).code, 0);
  json plain = rig;
  plain.erase("readout");
  plain["offsets"][0].erase("readout");
  ASSERT_EQ(makeExposed(folder, "still", plain, {"--name", "{camera}"}).code, 0);
  ASSERT_EQ(makeExposed(folder, "rows", plain, {"--name", "{camera}", "--readout", "0.03"}).code, 0);
  const auto set = filesOf(folder, "set"), still = filesOf(folder, "still"), rows = filesOf(folder, "rows");
  EXPECT_TRUE(set.at("orbit1-a.png") == still.at("orbit1-a.png"));
  EXPECT_TRUE(set.at("orbit1-b.png") == rows.at("orbit1-b.png"));
  EXPECT_FALSE(set.at("orbit1-b.png") == still.at("orbit1-b.png"));
}

TEST(CameraExposure, NoiseSeeds) {
  Folder folder;
  const json list{{"type", "list"},
                  {"cameras",
                   {{{"name", "a"}, {"eye", {2, 2, 5}}, {"target", {0, 0, 0}}, {"noiseSeed", 7}},
                    {{"name", "b"}, {"eye", {2, 2, 5}}, {"target", {0, 0, 0}}, {"noiseSeed", 7}},
                    {{"name", "c"}, {"eye", {2, 2, 5}}, {"target", {0, 0, 0}}, {"noiseSeed", 8}},
                    {{"name", "d"}, {"eye", {2, 2, 5}}, {"target", {0, 0, 0}}}}}};
  const std::vector<std::string> noisy{"--name", "{camera}", "--full-well", "200"};
  const Outcome outcome = makeExposed(folder, "set", list, noisy);
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto set = filesOf(folder, "set");
  EXPECT_TRUE(set.at("a.png") == set.at("b.png"));
  EXPECT_FALSE(set.at("a.png") == set.at("c.png"));
  EXPECT_FALSE(set.at("a.png") == set.at("d.png"));
}

// The keys that a set's camera files have are those that the camera sources "transforms" and "bop" read.
TEST(CameraExposure, IsInTheCameraFilesOfASet) {
  Folder folder;
  const json cameras = orbit({{"shutter", 0.04}, {"noiseSeed", 5}});
  ASSERT_EQ(makeExposed(folder, "set", cameras, {"--formats", "transforms", "--formats", "bop"}).code, 0);
  const json transforms = json::parse(folder.read("set/transforms.json"))["frames"][3];
  const json bop = json::parse(folder.read("set/train/000000/scene_camera.json"))["3"];
  for (const json& entry : {transforms, bop}) {
    EXPECT_EQ(entry.value("shutter", 0.0), 0.04);
    EXPECT_EQ(entry.value("noiseSeed", 0), 5);
    EXPECT_FALSE(entry.contains("readout"));
  }
  const json again = {{"type", "transforms"}, {"file", (folder.path() / "set/transforms.json").string()}};
  ASSERT_EQ(makeExposed(folder, "again", again, {"--formats", "transforms"}).code, 0);
  EXPECT_EQ(json::parse(folder.read("again/transforms.json"))["frames"][3].value("shutter", 0.0), 0.04);
}

// A camera's stops are those of the option. f/4, 1/60 s and ISO 960 are log2(960 / 60 / 1600) stops, by USD's formula.
TEST(CameraExposure, Stops) {
  Folder folder;
  const json settings{{"shutter", 1.0 / 60}, {"ISO", 960}, {"fNumber", 4}};
  json brighter = settings;
  brighter["EV"] = 6;
  const json cameras = {orbit({{"EV", 1.5}}), orbit(), orbit(settings), orbit(brighter)};
  const Outcome outcome = makeExposed(folder, "set", cameras, {"--formats", "transforms"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json plain = {orbit(), orbit()};
  ASSERT_EQ(makeExposed(folder, "bright", plain, {"--exposure", "1.5", "--formats", "transforms"}).code, 0);
  const auto set = filesOf(folder, "set"), bright = filesOf(folder, "bright");
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(set.at(fmt::format("images/{:06}.png", i)) == bright.at(fmt::format("images/{:06}.png", i)))
        << "frame " << i;
  const json frames = json::parse(folder.read("set/transforms.json"))["frames"];
  EXPECT_EQ(frames[0]["EV"], 1.5);
  EXPECT_FALSE(frames[4].contains("EV"));
  EXPECT_NEAR(frames[8]["EV"].get<double>(), std::log2(0.01), 1e-12);
  EXPECT_NEAR(frames[12]["EV"].get<double>(), 6 + std::log2(0.01), 1e-12);
  const json again = {{"type", "transforms"}, {"file", (folder.path() / "set/transforms.json").string()}};
  ASSERT_EQ(makeExposed(folder, "again", again, {"--formats", "transforms"}).code, 0);
  EXPECT_TRUE(filesOf(folder, "again").at("images/000013.png") == set.at("images/000013.png"));
  const Outcome wrong = makeExposed(folder, "wrong", orbit({{"ISO", 100}, {"shutter", 0.01}}));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("\"ISO\" and \"fNumber\" require each other and \"shutter\""));
}

TEST(CameraExposure, ResumedIfItChangesAndRejectedIfWrong) {
  Folder folder;
  ASSERT_EQ(makeExposed(folder, "set", orbit({{"shutter", 0.04}})).code, 0);
  ASSERT_EQ(makeExposed(folder, "set", orbit({{"shutter", 0.02}}), {"--resume"}).code, 0);
  const std::string log = folder.read("set/.latelight/log");
  EXPECT_THAT(log.substr(log.rfind("begins: ")), HasSubstr("begins: 4 of 4 frames are to be rendered"));
  ASSERT_EQ(makeExposed(folder, "fresh", orbit({{"shutter", 0.02}})).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "fresh"));
  const Outcome wrong = makeExposed(folder, "wrong", orbit({{"shutter", -1}}));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("cameras.shutter"));
}

}  // namespace
}  // namespace latelight::data
