// Frames that cannot be rendered or written are listed, the batch continues, and --resume renders them later. Signals
// end a batch between frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "batch/sets.h"
#include "data/batch/shard_log.h"
#include "small_disk.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

TEST(Failures, ABrokenSceneAmongGoodOnesIsMadeOnceItIsRepaired) {
  Folder folder;
  for (const char* name : {"a.gltf", "b.gltf", "c.gltf"}) folder.write(name, std::string_view(kCameraAlone));
  folder.write("b.gltf", std::string_view("{\"asset\": "));
  const auto job = [&](const std::string& set, std::vector<std::string> more) {
    more.insert(more.begin(), {"--scenes", "?.gltf", "--repeat", "2", "-o", set});
    return batch(folder, more);
  };
  const Outcome outcome = latelight(job("set", {}));
  EXPECT_EQ(outcome.code, 6) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr("b.gltf: "));
  EXPECT_THAT(outcome.err, testing::Not(HasSubstr("b.gltf: b.gltf")));
  EXPECT_THAT(outcome.err, HasSubstr("2 of 6 frames were not made"));
  EXPECT_TRUE(fs::exists(folder.path() / "set/000005.png"));
  EXPECT_FALSE(fs::exists(folder.path() / "set/000002.png"));
  const Outcome status = latelight({.arguments = {"batch", "status", "set"}, .folder = folder.path()});
  EXPECT_EQ(status.code, 6);
  EXPECT_THAT(status.out, testing::StartsWith("b.gltf: "));
  EXPECT_THAT(status.out, testing::Not(HasSubstr("b.gltf: b.gltf")));

  folder.write("b.gltf", std::string_view(kCameraAlone));
  const Outcome resumed = latelight(job("set", {"--resume"}));
  EXPECT_EQ(resumed.code, 0) << resumed.text();
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("begins: 2 of 6 frames"));
  EXPECT_EQ(latelight(job("undisturbed", {})).code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "undisturbed"));
}

// No frame of the job can ever be rendered, whichever scene is first.
TEST(Failures, AUnitForAScenesThatDefinesItIsAUsageError) {
  Folder folder;
  folder.write("a.gltf", std::string_view(kCameraAlone));
  folder.write("b.stl", std::string_view("solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                         "vertex 0 1 0\nendloop\nendfacet\nendsolid b\n"));
  for (const std::vector<std::string>& scenes : {std::vector<std::string>{"a.gltf", "b.stl"}, {"b.stl", "a.gltf"}})
    for (const bool isDry : {true, false}) {
      std::vector<std::string> job{"--scenes", scenes[0], "--scenes", scenes[1], "--unit", "mm", "-o", "set"};
      if (isDry) job.emplace_back("--dry-run");
      const Outcome outcome = latelight(batch(folder, job));
      EXPECT_EQ(outcome.code, 2) << outcome.text();
      EXPECT_THAT(outcome.err, HasSubstr("a.gltf defines its unit and axes"));
    }
}

TEST(Failures, WhatIsMissingMayBeLeftOut) {
  Folder folder;
  folder.write("a.gltf", std::string_view(kCameraAlone));
  folder.write("b.gltf", std::string_view("no"));
  EXPECT_EQ(latelight(batch(folder, {"--scenes", "?.gltf", "-o", "set"})).code, 6);
  EXPECT_FALSE(fs::exists(folder.path() / "set/manifest.json"));
  EXPECT_EQ(latelight({.arguments = {"batch", "merge", "set", "--allow-missing"}, .folder = folder.path()}).code, 0);
  const auto manifest = nlohmann::json::parse(folder.read("set/manifest.json"));
  EXPECT_EQ(manifest["frames"].size(), 1u);
  EXPECT_THAT(manifest["failed"][0]["name"].get<std::string>(), HasSubstr("b.gltf"));
}

TEST(Failures, ASetWhoseMergeFailedIsReported) {
  Folder folder;
  const auto run = [&](const char* command) {
    return latelight({.arguments = {"batch", command, "set"}, .folder = folder.path()});
  };
  fs::create_directories(folder.path() / "set/.latelight");
  fs::create_directories(folder.path() / "set/annotations/instances.json");
  const Outcome outcome = latelight(
      batch(folder, {"--scenes", "builtin:boxes", "--repeat", "2", "--formats", "coco", "-o", "set", "--resume"}));
  EXPECT_EQ(outcome.code, 2) << outcome.text();
  for (const char* command : {"status", "verify"}) {
    const Outcome unmerged = run(command);
    EXPECT_EQ(unmerged.code, 3) << unmerged.text();
    EXPECT_THAT(unmerged.err, HasSubstr("all frames of 'set' are finished, but not merged: run latelight batch merge"));
  }
  fs::remove(folder.path() / "set/annotations/instances.json");
  for (const char* command : {"merge", "status", "verify"}) EXPECT_EQ(run(command).code, 0) << command;
}

TEST(Failures, AFrameThatCantBeWrittenTakesNoOtherWithIt) {
  Folder folder;
  const std::vector<std::string> job{"--scenes", "builtin:boxes", "--repeat", "4", "-o", "set", "--resume"};
  fs::create_directories(folder.path() / "set/.latelight");
  fs::create_directories(folder.path() / "set/000002.png");
  const Outcome outcome = latelight(batch(folder, job));
  EXPECT_EQ(outcome.code, 6);
  EXPECT_THAT(outcome.err, HasSubstr("000002: "));
  EXPECT_THAT(outcome.err, HasSubstr("1 of 4 frames were not made"));
  EXPECT_TRUE(fs::exists(folder.path() / "set/000003.png"));
  fs::remove(folder.path() / "set/000002.png");
  EXPECT_EQ(latelight(batch(folder, job)).code, 0);
  EXPECT_EQ(filesOf(folder, "set").size(), 5u);
}

// Files that a format has written before it fails are removed, as are those of the formats before it.
TEST(Failures, AFrameThatCantBeWrittenLeavesNoFiles) {
  Folder folder;
  const auto filesWithout = [&](const char* blocked, const char* format) {
    const std::string set = "set-" + std::string(blocked);
    fs::create_directories(folder.path() / set / ".latelight");
    fs::create_directories((folder.path() / set / blocked).parent_path());
    folder.write(set + "/" + blocked, std::string_view("a file in place of a folder"));
    const Outcome outcome = latelight(
        batch(folder, {"--scenes", "builtin:boxes", "--formats", "exr", "--formats", format, "-o", set, "--resume"}));
    EXPECT_EQ(outcome.code, 6) << outcome.text();
    std::vector<std::string> names;
    for (const auto& [name, contents] : filesOf(folder, set)) names.push_back(name);
    return names;
  };
  using testing::ElementsAre;
  EXPECT_THAT(filesWithout("label_2", "kitti"), ElementsAre("label_2"));
  EXPECT_THAT(filesWithout("calib", "kitti"), ElementsAre("calib"));
  EXPECT_THAT(
      filesWithout("depth", R"({"format": "files", "outputs": ["color", "depth"], "pattern": "{aov}/{name}.exr"})"),
      ElementsAre("depth"));
}

TEST(Failures, AFullDiskLeavesOnlyWholeFrames) {
  test::SmallDisk disk(96 << 10);
  if (!disk) GTEST_SKIP() << "no right to mount";
  Folder folder;
  const std::vector<std::string> job{"--scenes", "builtin:boxes", "--repeat",
                                     "40",       "--formats",     R"({"format": "files", "pattern": "{name}.exr"})"};
  const auto into = [&](const std::string& set, std::vector<std::string> more) {
    more.insert(more.begin(), job.begin(), job.end());
    more.insert(more.end(), {"-o", set});
    return batch(folder, more);
  };
  ASSERT_EQ(latelight(into("whole", {})).code, 0);
  const auto whole = filesOf(folder, "whole");
  fs::create_directory_symlink(disk.path(), folder.path() / "disk");
  const Outcome full = latelight(into("disk/set", {}));
  EXPECT_THAT(full.code, testing::AnyOf(2, 6)) << full.text();
  auto there = filesOf(folder, "disk/set");
  EXPECT_LT(there.size(), whole.size());
  there.erase("manifest.json");
  expectPartOf(there, whole);
  // A higher limit, as if another process had freed space on the disk.
  ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT, "size=8M"), 0);
  const Outcome resumed = latelight(into("disk/set", {"--resume"}));
  EXPECT_EQ(resumed.code, 0) << resumed.text();
  expectSame(filesOf(folder, "disk/set"), whole);
}

// Lines of a shard's log that do not fit are not of a full disk.
TEST(Failures, AFileSizeLimitIsTheReason) {
  Folder folder;
  const fs::path path = folder.path() / "shard.jsonl";
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    ShardLog log(path, {.plan = 1});
    for (uint64_t i = 0; i < 100; ++i) log.finished({.index = i, .name = "a frame"});
    std::string message;
    try {
      log.end();
    } catch (const Error& error) {
      message = error.what();
    }
    _exit(message.find("File too large; raise the file size limit") == std::string::npos);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const size_t frames = readShardLog(path).frames.size();  // only whole lines
  EXPECT_GE(frames, 1u);
  EXPECT_LT(frames, 100u);
}

TEST(Failures, PlacesWhereNothingCanBeMade) {
  Folder folder;
  folder.write("file", std::string_view("x"));
  fs::create_directory(folder.path() / "other");
  folder.write("other/photo.png", std::string_view("mine"));
  const auto into = [&](const std::string& set) {
    return latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", set}));
  };
  for (const char* place : {"file", "file/set", "/proc/set", "other", "a{b}"}) {
    const Outcome outcome = into(place);
    EXPECT_EQ(outcome.code, 2) << place << ": " << outcome.text();
  }
  EXPECT_EQ(folder.read("other/photo.png"), "mine");
}

// A corrected job needs no --resume.
TEST(Failures, AJobWithoutCamerasLeavesNoFolder) {
  Folder folder;
  folder.write("a.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{}]})");
  const Outcome outcome = latelight(batch(folder, {"--scenes", "a.gltf", "-o", "set"}));
  EXPECT_EQ(outcome.code, 2) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr(R"(a.gltf has no cameras of its own: add some, for example with --cameras ')"));
  EXPECT_FALSE(fs::exists(folder.path() / "set"));
  fs::create_directory(folder.path() / "set");
  EXPECT_EQ(latelight(batch(folder, {"--scenes", "a.gltf", "-o", "set"})).code, 2);
  EXPECT_FALSE(fs::exists(folder.path() / "set/.latelight"));
  EXPECT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set"})).code, 0);
  EXPECT_EQ(latelight(batch(folder, {"--scenes", "a.gltf", "-o", "set", "--resume"})).code, 2);
  EXPECT_TRUE(fs::exists(folder.path() / "set/manifest.json"));
}

// Frames in flight are written, no file is incomplete, and --resume renders the rest.
TEST(Signals, EndABatchBetweenFrames) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Folder folder;
    app::Command command = batch(folder, {"--scenes", "builtin:boxes", "--repeat", "100000", "-o", "set"});
    command.until = [&] {  // some frames are finished
      return std::ranges::count(folder.read("set/.latelight/shard-0-of-1.jsonl"), '\n') > 5;
    };
    command.lastSignal = signal;
    const Outcome outcome = latelight(command);
    ASSERT_TRUE(outcome.timedOut) << "it ended before the signal: " << outcome.text();
    EXPECT_EQ(outcome.code, 6) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(signal == SIGINT ? "stopped by SIGINT with " : "stopped by SIGTERM with "));
    const Outcome verify = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
    EXPECT_EQ(verify.code, 0) << verify.text();
    // The manifest lists every frame that exists, so none was rendered in vain.
    const std::string said = verify.out.substr(verify.out.find("of ") + 3);
    EXPECT_EQ(std::to_string(filesOf(folder, "set").size()) + " frames are as they were written\n", said);
  }
}

// Ends a job with a signal after some time. Returns the seconds that it then took to stop.
double secondsAfter(int signal, app::Command command, Outcome& outcome) {
  const auto start = std::chrono::steady_clock::now();
  command.timeout = std::chrono::milliseconds(2000);
  command.lastSignal = signal;
  outcome = latelight(command);
  EXPECT_TRUE(outcome.timedOut) << "it ended before the signal: " << outcome.text();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() - 2;
}

// 10,000 objects with 100,000 attempts each, few of which find a free position.
TEST(Signals, EndABatchWhileItScatters) {
  Folder folder;
  folder.write("job.json", std::string_view(R"({"scenes": "builtin:boxes", "output": "set", "variations": [
    {"type": "scatter", "objects": [{"node": "matte"}], "count": 10000, "on": "floor", "tries": 100000, "scale": 0.5}]})"));
  Outcome outcome;
  EXPECT_LT(secondsAfter(SIGTERM, batch(folder, {"job.json"}), outcome), 1.5);
  EXPECT_EQ(outcome.code, 6) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr("stopped by SIGTERM with 0 of 1 frames"));
}

// Many positions in a hall, each tested against all of its geometry, take minutes.
TEST(Signals, EndABatchWhileCamerasAreSought) {
  Folder folder;
  folder.write("job.json", std::string_view(R"({"scenes": "builtin:hall", "output": "set", "cameras":
    {"type": "box", "count": 300000, "clearance": 0.2}})"));
  Outcome outcome;
  EXPECT_LT(secondsAfter(SIGINT, batch(folder, {"job.json"}), outcome), 1.5);
  EXPECT_EQ(outcome.code, 6) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr("stopped by SIGINT before the first frame of 'set' was begun"));
}

}  // namespace
}  // namespace latelight::data
