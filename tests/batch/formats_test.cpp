// The batch renders the additional outputs that formats require.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

TEST(FormatsOfABatch, CryptomatteAloneNamesTheObjects) {
  Folder folder;
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "cryptomatte", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  const auto matte = files.find("cryptomatte/000000.exr");
  ASSERT_NE(matte, files.end());
  EXPECT_THAT(matte->second, HasSubstr(R"("/boxes/plastic":")"));
}

TEST(FormatsOfABatch, BoxesAloneHaveObjects) {
  Folder folder;
  const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "boxes", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(filesOf(folder, "set")["boxes/000000.json"], HasSubstr(R"("node":"/boxes/plastic")"));
}

TEST(FormatsOfABatch, WhatHoldsCamerasIsReadAgainAsTheSameViews) {
  Folder folder;
  const char* orbit = R"({"type": "orbit", "count": 3, "distance": 4})";
  const Outcome outcome = latelight(
      batch(folder, {"--scenes", "builtin:boxes", "--cameras", orbit, "--formats", "bop", "--formats", "transforms",
                     "--formats", R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto set = filesOf(folder, "set");
  int sets = 0;
  for (const char* source : {R"({"type": "bop", "file": "set/train/000000/scene_camera.json", "size": [32, 24]})",
                             R"({"type": "transforms", "file": "set/transforms.json"})"}) {
    const std::string name = fmt::format("again{}", sets++);
    const Outcome again = latelight(batch(folder, {"--scenes", "builtin:boxes", "--cameras", source, "--formats",
                                                   R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", name}));
    ASSERT_EQ(again.code, 0) << again.text();
    auto same = filesOf(folder, name);
    std::erase_if(same, [](const auto& file) { return !file.first.starts_with("d/"); });
    EXPECT_EQ(same.size(), 3u);
    expectPartOf(same, set);
  }
}

// "none" is the absence of an environment, as for --hdri.
TEST(VariationsOfABatch, MayDrawNoEnvironment) {
  Folder folder;
  const auto run = [&](const std::string& set, const std::vector<std::string>& environment) {
    std::vector<std::string> all{"--scenes", "builtin:boxes", "-o", set};
    all.insert(all.end(), environment.begin(), environment.end());
    const Outcome outcome = latelight(batch(folder, all));
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return folder.read(set + "/000000.png");
  };
  const std::string drawn = run("drawn", {"--variations", R"([{"type": "environments", "environments": "none"}])"});
  const std::string none = run("none", {"--hdri", "none"}), studio = run("studio", {"--hdri", "studio"});
  EXPECT_FALSE(drawn.empty());
  EXPECT_TRUE(drawn == none);
  EXPECT_FALSE(none == studio);
}

const std::vector<std::string> kArchives{"--scenes", "builtin:boxes", "--formats",
                                         R"({"format": "webdataset", "frames": 3})"};

Outcome archives(const Folder& folder, const std::string& set, std::vector<std::string> more) {
  std::vector<std::string> all = kArchives;
  all.insert(all.end(), {"-o", set});
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

// Keys end at the first period, which the format replaces: two names may then be equal.
TEST(FormatsOfABatch, ArchivesHaveOneKeyPerFrame) {
  Folder folder;
  for (const char* name : {"a.b.gltf", "a_b.gltf"}) folder.write(name, std::string_view(kCameraAlone));
  const auto run = [&](const char* name) {
    return latelight(
        batch(folder, {"--scenes", "a?b.gltf", "--formats", "webdataset", "-o", "set", "--resume", "--name", name}));
  };
  const Outcome equal = run("{scene}");
  EXPECT_EQ(equal.code, 2) << equal.text();
  EXPECT_THAT(equal.err, HasSubstr(R"(the format webdataset stores the frames "a.b" and "a_b" as "a_b"; add {index})"));
  EXPECT_EQ(run("{scene}-{index}").code, 0);
}

// Frames are in archives only: their own files are removed, and none is rendered again.
TEST(FormatsOfABatch, ArchivesAreCompletedAndExtended) {
  Folder folder;
  ASSERT_EQ(archives(folder, "whole", {"--repeat", "7"}).code, 0);
  const auto whole = filesOf(folder, "whole");
  EXPECT_EQ(whole.size(), 3 + 1u);
  EXPECT_EQ(std::filesystem::exists(folder.path() / "whole/shards/.frames"), false);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "4"}).code, 0);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "7", "--resume"}).code, 0);
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("begins: 3 of 7 frames"));
  expectSame(filesOf(folder, "set"), whole);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "4", "--resume"}).code, 0);
  ASSERT_EQ(archives(folder, "four", {"--repeat", "4"}).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "four"));
}

TEST(FormatsOfABatch, ArchivesAreThoseOfOneProcessForAnyShards) {
  Folder folder;
  ASSERT_EQ(archives(folder, "whole", {"--repeat", "5"}).code, 0);
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--shard", "1/2"}).code, 0);
  EXPECT_FALSE(filesOf(folder, "set").contains("shards/000000.tar"));
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--shard", "0/2"}).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "whole"));
}

TEST(FormatsOfABatch, DamagedArchivesAreFoundAndWrittenAgain) {
  Folder folder;
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5"}).code, 0);
  const auto before = filesOf(folder, "set");
  folder.write("set/shards/000000.tar", before.at("shards/000000.tar").substr(0, 3000));
  const Outcome verified = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
  EXPECT_EQ(verified.code, 3);
  EXPECT_THAT(verified.out + verified.err, HasSubstr("'shards/000000.tar' is not as it was written"));
  ASSERT_EQ(archives(folder, "set", {"--repeat", "5", "--resume"}).code, 0);
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("begins: 3 of 5 frames"));
  expectSame(filesOf(folder, "set"), before);
}

}  // namespace
}  // namespace latelight::data
