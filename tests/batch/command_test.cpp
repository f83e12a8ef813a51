// The command line of batch: values that begin with brackets, and names that are invalid for files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "batch/sets.h"
#include "small_disk.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

app::Command dryRun(const Folder& folder, std::vector<std::string> more) {
  std::vector<std::string> all{"--scenes", "builtin:boxes", "-o", "set", "--dry-run"};
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

// Returns the number of frames that the command reports.
std::string frames(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  const size_t line = outcome.out.rfind('\n', outcome.out.size() - 2) + 1;
  return outcome.out.substr(line, outcome.out.find(' ', line) - line);
}

TEST(BatchCommand, TakesListsAsJson) {
  const Folder folder;
  EXPECT_EQ(frames(latelight(dryRun(folder, {"--cameras", R"([{"type": "scene"}, {"type": "orbit", "count": 5}])"}))),
            "6");
  EXPECT_EQ(frames(latelight(dryRun(folder, {R"(--cameras=[{"type": "orbit", "count": 5, "elevation": [1, 2]}])"}))),
            "5");
  EXPECT_EQ(frames(latelight(
                dryRun(folder, {"--variations", R"([{"type": "lights", "intensity": [0.5, 2]}])", "--repeat", "3"}))),
            "3");
  EXPECT_EQ(frames(latelight(dryRun(folder, {"--formats", R"(["coco", {"format": "depth-png", "unit": "kitti"}])"}))),
            "1");
  const Outcome wrong = latelight(dryRun(folder, {"--cameras", R"([{"type": "scene"})"}));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--cameras takes a name or JSON"));
}

// One element per option, or several: none is lost.
TEST(BatchCommand, ListsMayBeGivenInParts) {
  const Folder folder;
  ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set", "--formats", R"(["npz", "ply"])",
                                     "--formats", "exr", "--formats", R"([{"format": "boxes"}])"}))
                .code,
            0);
  const auto files = filesOf(folder, "set");
  for (const char* name : {"000000.npz", "points/000000.ply", "000000.exr", "boxes/000000.json"})
    EXPECT_TRUE(files.contains(name)) << name;
}

TEST(BatchCommand, NamesMayHaveBracketsAndCommas) {
  const Folder folder;
  for (const char* set : {"[set]", "[a,b]", "a,b"}) {
    ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", set})).code, 0) << set;
    EXPECT_TRUE(fs::exists(folder.path() / set / "manifest.json")) << set;
    EXPECT_EQ(latelight({.arguments = {"batch", "status", set}, .folder = folder.path()}).code, 0) << set;
  }
  folder.write("[x,y].gltf", std::string_view(kCameraAlone));
  EXPECT_EQ(frames(latelight(batch(folder, {"--scenes", "[x,y].gltf", "-o", "set", "--dry-run"}))), "1");
  fs::create_directory(folder.path() / "[f,g]");
  EXPECT_EQ(frames(latelight(dryRun(folder, {"--allow-outside", "[f,g]", "--id-nodes", "floor"}))), "1");
}

// Words after an option's value are not further values of the option.
TEST(BatchCommand, AValueIsOneWord) {
  const Folder folder;
  EXPECT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "builtin:hall", "-o", "set", "--dry-run"})).code, 2);
}

TEST(BatchCommand, NamesThatNoFileCanHave) {
  const Folder folder;
  const std::string name(300, 'x');
  const auto code = [&](std::vector<std::string> arguments) {
    const Outcome outcome = latelight({.arguments = std::move(arguments), .folder = folder.path()});
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("internal error"))) << outcome.text();
    EXPECT_LT(outcome.err.size(), 3 * name.size()) << outcome.err;  // a sentence quotes it at most twice, shortened
    return outcome.code;
  };
  EXPECT_EQ(code({"batch", "--scenes", name, "-o", "o"}), 3);
  EXPECT_EQ(code({"batch", "--scenes", name + "/*.glb", "-o", "o"}), 3);
  EXPECT_EQ(code({"batch", "--scenes", "builtin:boxes", "--hdri", name + ".hdr", "-o", "o", "--dry-run"}), 3);
  EXPECT_EQ(code({"batch", "--scenes", "builtin:boxes", "--hdri", name + "/a.hdr", "-o", "o", "--dry-run"}), 3);
  EXPECT_EQ(code({"batch", "status", name}), 3);
  EXPECT_EQ(code({"batch", "verify", name}), 3);
  EXPECT_EQ(code({"batch", "merge", name}), 3);
  EXPECT_EQ(code({"batch", name + ".yaml"}), 3);
  EXPECT_EQ(code({"batch", "--scenes", "builtin:boxes", "-o", name}), 2);
  EXPECT_EQ(code({"render", "builtin:boxes", "--hdri", name + ".hdr", "-o", "a.png", "--device", "cpu"}), 3);
  EXPECT_EQ(code({"render", "builtin:boxes", "-o", name + ".png", "--device", "cpu"}), 2);
  EXPECT_EQ(code({"serve", "builtin:boxes", "--hdri", name + ".hdr", "--port", "0", "--device", "cpu"}), 3);
}

TEST(BatchCommand, FoldersWithoutADataSetAreReported) {
  const Folder folder;
  fs::create_directory(folder.path() / "empty");
  for (const char* command : {"status", "verify", "merge"})
    for (const char* name : {"empty", "missing"}) {
      const Outcome outcome = latelight({.arguments = {"batch", command, name}, .folder = folder.path()});
      EXPECT_EQ(outcome.code, 3) << command;
      EXPECT_EQ(outcome.err, std::string("latelight: '") + name + "' holds no data set\n") << command;
    }
  EXPECT_TRUE(fs::is_empty(folder.path() / "empty"));
}

// The line is that of the file, and nothing in the message is of the library that parses JSON.
TEST(BatchCommand, DamagedManifestsNameTheLine) {
  const Folder folder;
  ASSERT_EQ(
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--repeat", "2", "-o", "set", "--shard", "0/2"})).code, 0);
  const std::string log = "set/.latelight/shard-0-of-2.jsonl", text = folder.read(log);
  ASSERT_EQ(std::ranges::count(text, '\n'), 2) << text;
  const auto expectError = [&](const std::string& file, const std::string& contents, const char* reason) {
    folder.write(file, contents);
    const Outcome outcome = latelight({.arguments = {"batch", "status", "set"}, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr(file + "' is not a manifest of a data set (" + reason));
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("json.exception")));
  };
  expectError(log, text + "{\"frame\": \n", "line 3: parse error at column 11: ");
  expectError(log, text + "\n", "line 3: parse error at column 1: ");
  expectError(log, text + "{\"frame\": {}}\n" + text, "line 3: key 'index' not found");
  expectError(log, text + "{\"stale\": 3}\n", "line 3: type must be array");
  folder.write(log, text);
  expectError("set/manifest.json", "{\n\"plan\": }\n", "parse error at line 2, column 9: ");
}

TEST(BatchCommand, StatusAndVerifyTreatEveryFolder) {
  const Folder folder;
  for (const char* name : {"a", "b", "[a,b]"})
    ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", name})).code, 0);
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "batch");
    return latelight({.arguments = arguments, .folder = folder.path()});
  };
  EXPECT_EQ(run({"verify", "a"}).out, "the files of 1 frames are as they were written\n");
  EXPECT_EQ(run({"verify", "a", "b", "[a,b]", "-q"}).out,
            "a: the files of 1 frames are as they were written\nb: the files of 1 frames are as they were written\n"
            "[a,b]: the files of 1 frames are as they were written\n");
  EXPECT_EQ(run({"status", "[a,b]", "b"}).out, "[a,b]: 1 of 1 frames are finished\nb: 1 of 1 frames are finished\n");
  folder.write("b/000000.png", "damaged");
  const Outcome damaged = run({"verify", "a", "b", "[a,b]"});
  EXPECT_EQ(damaged.code, 3);
  EXPECT_THAT(damaged.err, HasSubstr("1 file of 'b' differs from what was written"));
  EXPECT_THAT(damaged.out, HasSubstr("[a,b]: the files of 1 frames")) << "folders after a damaged one are checked";
  EXPECT_EQ(run({"verify", "a", "missing"}).code, 3);
  EXPECT_EQ(run({"status", "a", "missing"}).code, 3);
}

TEST(BatchCommand, FoldersHaveNoJob) {
  const Folder folder;
  ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "a"})).code, 0);
  const std::vector<std::pair<std::vector<std::string>, const char*>> wrong{
      {{"nope.yaml", "status", "a"}, "omit nope.yaml"},
      {{"--resume", "verify", "a"}, "omit --resume"},
      {{"verify", "a", "--resume", "--shard", "9/3"}, "--resume"},
      {{"status", "a", "nonsense", "--size", "8x8"}, "--size"},
      {{"merge", "a", "b"}, "b"},
      {{"merge", "a", "--resume"}, "--resume"}};
  for (const auto& [words, part] : wrong) {
    std::vector<std::string> arguments{"batch"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 2) << part;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr(part));
  }
}

// The lines are those of the entries. Values of the command line have none.
TEST(BatchCommand, ErrorsInCamerasAndVariationsNameTheLine) {
  const Folder folder;
  const auto errorOf = [&](const std::string& text, std::vector<std::string> more = {}) {
    folder.write("job.yaml", "scenes: builtin:boxes\noutput: set\n" + text);
    more.insert(more.begin(), {"job.yaml", "--dry-run"});
    const Outcome outcome = latelight(batch(folder, more));
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    return outcome.err;
  };
  EXPECT_THAT(errorOf("variations:\n  - type: materials\n    roughness: 7\n"),
              HasSubstr("latelight: job.yaml:4: variations[0].roughness must be a number from 0 to 1, not 7"));
  EXPECT_THAT(errorOf("variations:\n  - {type: materials, roughness: 1}\n  - {type: weather}\n"),
              HasSubstr("latelight: job.yaml:5: variations[1].type must be one of"));
  EXPECT_THAT(errorOf("cameras:\n  type: orbit\n  count: none\n"),
              HasSubstr("latelight: job.yaml:5: cameras.count must be a whole number"));
  EXPECT_THAT(errorOf("cameras:\n  - type: scene\n  - type: list\n    cameras:\n      - eye: [0, 1]\n"),
              HasSubstr("latelight: job.yaml:5: cameras[1].cameras[0].eye must be"));
  EXPECT_THAT(errorOf("variations:\n  - type: visibility\n", {"--variations", R"([{"type": "weather"}])"}),
              HasSubstr("latelight: variations[0].type must be one of"));
  EXPECT_THAT(errorOf("repeat: 3\n", {"--variations", R"([{"type": "weather"}])"}),
              HasSubstr("latelight: variations[0].type must be one of"));
  EXPECT_THAT(errorOf("formats:\n  - files\n", {"--formats", "painting"}),
              HasSubstr("latelight: formats[0]: there is no format"));
}

// Options of the command line replace keys of a job file, but another value than an object has no keys.
TEST(BatchCommand, JobFilesAreObjects) {
  const Folder folder;
  const auto run = [&](const std::string& name, const std::string& text) {
    folder.write(name, text);
    return latelight(batch(folder, {name, "--scenes", "builtin:boxes", "-o", "set", "--dry-run"}));
  };
  for (const char* text : {"[]", "[1]", "3", "\"x\"", "true"})
    for (const char* name : {"job.json", "job.yaml"}) {
      const Outcome outcome = run(name, text);
      EXPECT_EQ(outcome.code, 2) << text << outcome.text();
      EXPECT_EQ(outcome.err, fmt::format("latelight: {}:1: a job is an object of keys and values\n", name)) << text;
    }
  for (const char* text : {"plain words", "- a\n- b\n"}) {
    const Outcome outcome = run("job.yaml", text);
    EXPECT_EQ(outcome.code, 2) << text << outcome.text();
    EXPECT_EQ(outcome.err, "latelight: job.yaml:1: a job is an object of keys and values\n") << text;
  }
  EXPECT_EQ(frames(run("job.yaml", "# no keys\n")), "1");
}

// The renderer rejects these options, so no frame could be rendered.
TEST(BatchCommand, OptionsThatNoFrameSupportsAreRejected) {
  const Folder folder;
  const auto expectRejected = [&](std::vector<std::string> job, const std::string& sentence) {
    for (const char* dry : {"--dry-run", "--quiet"}) {
      std::vector<std::string> all = job;
      all.insert(all.end(), {"-o", "set", dry});
      const Outcome outcome = latelight(batch(folder, all));
      EXPECT_EQ(outcome.code, 2) << outcome.text();
      EXPECT_THAT(outcome.err, testing::StartsWith("latelight: " + sentence));
      EXPECT_FALSE(fs::exists(folder.path() / "set")) << sentence;
    }
  };
  const auto expectOptionsRejected = [&](std::vector<std::string> options, const std::string& sentence) {
    options.insert(options.begin(), {"--scenes", "builtin:boxes"});
    expectRejected(options, sentence);
  };
  expectOptionsRejected({"--aa", "fxaa", "--bayer", "rggb"}, "--aa fxaa smooths the finished picture");
  expectOptionsRejected({"--aa", "fxaa", "--full-well", "1000"}, "--aa fxaa smooths the finished picture");
  expectOptionsRejected({"--black-level", "5000"}, "--black-level 5000 must be below");
  expectOptionsRejected({"--layout", "killzone2", "--normals", "octahedral"}, "--normals does not apply to the layout");
  expectOptionsRejected({"--layout", "exact", "--position", "reciprocal", "--lighting", "forward"},
                        "--position does not apply to the layout");
  expectOptionsRejected({"--shadow-lights", "zz"}, "no light is called \"zz\": --shadow-lights takes");
  expectOptionsRejected({"--shadow-lights", "zz", "--scenes", "builtin:hall"}, "no light is called \"zz\"");
  expectOptionsRejected({"--background", "hdri", "--hdri", "none"}, "--background hdri requires an environment");
  const std::string environments = R"([{"type": "environments", "environments": ["studio", "none"]}])";
  expectOptionsRejected({"--background", "hdri", "--variations", environments},
                        "--background hdri requires an environment");
  folder.write("job.yaml",
               std::string_view("scenes: builtin:boxes\nhdri: none\noptions:\n  bloom: 0.1\n  shadow-lights: zz\n"));
  expectRejected({"job.yaml"}, "job.yaml:5: options.shadow-lights: no light is called \"zz\"");
  expectRejected({"job.yaml", "--shadow-lights", "yy"}, "no light is called \"yy\"");
  folder.write("job.yaml", std::string_view("scenes: builtin:boxes\nhdri: none\noptions:\n  background: hdri\n"));
  expectRejected({"job.yaml"}, "job.yaml:4: options.background: --background hdri requires an environment");
}

// The same options where they have a meaning.
TEST(BatchCommand, OptionsThatFramesSupportAreAccepted) {
  const Folder folder;
  const auto framesWith = [&](const std::vector<std::string>& options) {
    return frames(latelight(dryRun(folder, options)));
  };
  EXPECT_EQ(framesWith({"--shadow-lights", "zz", "--shadows", "none"}), "1");
  EXPECT_EQ(framesWith({"--shadow-lights", "zz", "--formats", "depth-png"}), "1");
  EXPECT_EQ(framesWith({"--shadow-lights", "sun", "--sun", "10,40"}), "1");
  const std::string studio = R"([{"type": "environments", "environments": "studio"}])";
  EXPECT_EQ(framesWith({"--background", "hdri", "--hdri", "none", "--variations", studio}), "1");
  EXPECT_EQ(framesWith({"--background", "hdri"}), "1");
  EXPECT_EQ(framesWith({"--layout", "optimized", "--normals", "octahedral"}), "1");
}

// A dry run fails if the run would fail.
TEST(BatchCommand, DryRunsCheckTheFolder) {
  const Folder folder;
  folder.write("file", std::string_view(""));
  std::filesystem::create_directories(folder.path() / "foreign");
  folder.write("foreign/mine", std::string_view("mine"));
  const std::pair<std::string, std::string> sets[] = {{"file", "'file' is not an empty folder"},
                                                      {"foreign", "'foreign' is not an empty folder"},
                                                      {"file/set", "can't create the folder 'file/set/.latelight'"},
                                                      {std::string(300, 'x'), "File name too long"},
                                                      {"a{b}", "has a brace in its name"}};
  for (const bool isDry : {true, false})
    for (const auto& [set, sentence] : sets) {
      std::vector<std::string> job{"--scenes", "builtin:boxes", "-o", set};
      if (isDry) job.emplace_back("--dry-run");
      const Outcome outcome = latelight(batch(folder, job));
      EXPECT_EQ(outcome.code, 2) << outcome.text();
      EXPECT_THAT(outcome.err, HasSubstr(sentence));
    }
  ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set"})).code, 0);
  EXPECT_THAT(latelight(dryRun(folder, {})).err, HasSubstr("'set' already contains a data set"));
  EXPECT_EQ(frames(latelight(dryRun(folder, {"--resume"}))), "0");
}

TEST(BatchCommand, DryRunsCheckTheFileSystem) {
  const test::SmallDisk disk(64 << 10);
  if (!disk) GTEST_SKIP() << "no right to mount";
  ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, ""), 0);
  const Folder folder;
  fs::create_directory_symlink(disk.path(), folder.path() / "disk");
  for (const char* dry : {"--dry-run", "--quiet"}) {
    const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "disk/set", dry}));
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr("can't create the folder 'disk/set/.latelight': Read-only file system"));
  }
}

// The numbers of a job are repeated as written.
TEST(BatchCommand, LargeNumbersAreRepeatedAsTheyAre) {
  const Folder folder;
  const Outcome outcome = latelight(dryRun(folder, {"--repeat", "9223372036854775808"}));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("not 9223372036854775808"));
}

}  // namespace
}  // namespace latelight::data
