// Batches that are killed, changed or damaged: after --resume, the data set equals that of an undisturbed run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "batch/sets.h"
#include "long_tests.h"
#include "output/read.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

const std::vector<std::string> kJob{"--scenes",  "builtin:boxes",
                                    "--repeat",  "400",
                                    "--formats", R"({"format": "files", "outputs": ["color", "depth", "id"]})",
                                    "--name",    "{variation}/{camera}"};

app::Command job(const Folder& folder, const std::string& set, std::vector<std::string> more = {}) {
  std::vector<std::string> all = kJob;
  all.insert(all.end(), {"-o", set});
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

// The lines of the shard's log: its first line, and one per finished frame.
auto linesOf(const Folder& folder, const std::string& set) {
  return std::ranges::count(folder.read(set + "/.latelight/shard-0-of-1.jsonl"), '\n');
}

// Kills the job repeatedly and compares all visible files each time. Every fifth time this happens after a random time
// during its start, before it has a frame; otherwise once it has finished a random number of further frames, from one
// to more than the set still needs. A finished set is started over. Returns how often some frames existed and others
// were missing.
int killOften(const Folder& folder, const std::string& set, int times, uint32_t seed,
              const std::map<std::string, std::string>& whole) {
  std::mt19937 random(seed);
  int partly = 0;
  for (int kills = 0; kills < times;) {
    app::Command command = job(folder, set, {"--resume", "--threads", std::to_string(1 + random() % 3)});
    const auto enough = std::max(linesOf(folder, set), 1l) + 1 + static_cast<long>(random() % 60);
    if (kills % 5 == 0)
      command.timeout = std::chrono::milliseconds(random() % 400);
    else
      command.until = [&] { return linesOf(folder, set) >= enough; };
    const Outcome outcome = latelight(command);
    EXPECT_TRUE(outcome.signal == SIGKILL || outcome.code == 0) << outcome.text();
    const std::map<std::string, std::string> there = filesOf(folder, set);
    expectPartOf(there, whole);
    if (outcome.code == 0) fs::remove_all(folder.path() / set);
    kills += outcome.code != 0;
    partly += !there.empty() && there.size() < whole.size();
  }
  return partly;
}

TEST(Resume, AHundredKillsLeaveTheSetOfAnUndisturbedRun) {
  Folder folder;
  const Outcome undisturbed = latelight(job(folder, "whole", {"--validate"}));
  ASSERT_EQ(undisturbed.code, 0) << undisturbed.text();
  const auto whole = filesOf(folder, "whole");
  ASSERT_EQ(whole.size(), 400 * 4 + 1u);
  const int kills = latelight::test::rounds(50, 10);
  app::inPairs(2, [&](size_t i) {
    const std::string set = "killed" + std::to_string(i);
    EXPECT_GT(killOften(folder, set, kills, static_cast<uint32_t>(i), whole), kills / 5);
    const Outcome last = latelight(job(folder, set, {"--resume"}));
    EXPECT_EQ(last.code, 0) << last.text();
    expectSame(filesOf(folder, set), whole);
  });
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    EXPECT_FALSE(entry.path().string().ends_with(".latelight-tmp")) << entry.path();
}

app::Command small(const Folder& folder, std::vector<std::string> more, const char* repeat = "3",
                   const char* scene = "builtin:boxes") {
  std::vector<std::string> all{"--scenes", scene, "--repeat", repeat, "-o", "set"};
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

std::string logOf(const Folder& folder) {
  return folder.read("set/.latelight/log");
}

TEST(Resume, AFinishedSetIsLeftAsItIs) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  const auto before = filesOf(folder, "set");
  const Outcome again = latelight(small(folder, {}));
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("'set' already contains a data set: add --resume"));
  EXPECT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 0 of 3 frames"));
  expectSame(filesOf(folder, "set"), before);
}

TEST(Resume, OtherSettingsAreRenderedAgainAndLeaveNothing) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {"--formats", R"({"format": "files", "pattern": "{name}.exr"})"})).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume", "--exposure", "1"})).code, 0);
  const auto resumed = filesOf(folder, "set");
  fs::remove_all(folder.path() / "set");
  ASSERT_EQ(latelight(small(folder, {"--exposure", "1"})).code, 0);
  expectSame(resumed, filesOf(folder, "set"));
}

TEST(Resume, MoreVariationsAreRenderedBesideThoseThatAreThere) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "5")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 2 of 5 frames"));
  const auto resumed = filesOf(folder, "set");
  fs::remove_all(folder.path() / "set");
  ASSERT_EQ(latelight(small(folder, {}, "5")).code, 0);
  expectSame(resumed, filesOf(folder, "set"));
}

TEST(Resume, FewerVariationsLeaveNothingOfTheOthers) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {}, "5")).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  const auto resumed = filesOf(folder, "set");
  EXPECT_EQ(resumed.size(), 3 + 1u);
}

TEST(Resume, ADamagedFileIsFoundAndMadeAgain) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  const auto before = filesOf(folder, "set");
  std::string damaged = before.at("000001.png");
  damaged[damaged.size() / 2] ^= 1;
  folder.write("set/000001.png", damaged);
  const Outcome verify = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
  EXPECT_EQ(verify.code, 3);
  EXPECT_THAT(verify.err, HasSubstr("'000001.png' is not as it was written"));
  fs::remove(folder.path() / "set/000001.png");
  EXPECT_EQ(latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}).code, 3);
  ASSERT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  EXPECT_EQ(latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}).code, 0);
  expectSame(filesOf(folder, "set"), before);
}

TEST(Resume, AChangedSceneIsRenderedAgain) {
  Folder folder;
  const std::string gltf = kCameraAlone;
  folder.write("scene.gltf", gltf);
  ASSERT_EQ(latelight(small(folder, {}, "3", "scene.gltf")).code, 0);
  folder.write("scene.gltf", gltf + " ");
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "3", "scene.gltf")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 3 of 3 frames are to be rendered\n"));
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "3", "scene.gltf")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 0 of 3 frames"));
}

// Returns the picture that the command render writes for the frame.
TEST(Resume, AFrameIsThePictureOfRender) {
  Folder folder;
  ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set", "--name", "{camera}"})).code, 0);
  const Outcome outcome = latelight({.arguments = {"render", "builtin:boxes", "--device", "cpu", "--camera", "main",
                                                   "--size", "32x24", "-o", "render.png"},
                                     .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_FALSE(folder.read("render.png").empty());
  EXPECT_TRUE(folder.read("render.png") == folder.read("set/main.png"));
}

}  // namespace
}  // namespace latelight::data
