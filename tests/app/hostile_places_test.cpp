// Hostile environments: outputs that overwrite inputs, pipes, links and full disks, streams that cannot be written,
// termination by signals, and names and arguments that are not valid text.
#include <fcntl.h>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"
#include "small_disk.h"

namespace latelight::app {
namespace {

namespace fs = std::filesystem;
using namespace models;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr int kUsage = 2, kBadInput = 3, kNoDevice = 4;
constexpr const char* kPng = "\x89PNG\r\n\x1a\n";

// A triangle that fills the view, with a buffer and a texture next to it. The name of its node contains control
// characters for terminals.
constexpr const char* kTriangle = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"mesh": 0, "name": "\u001b[2J\n\u009bx"}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                 "min": [-9, -9, 0], "max": [9, 9, 0]}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "s.bin", "byteLength": 36}],
  "images": [{"uri": "t%2Epng"}]})";

class Places : public testing::Test {
 protected:
  Places() {
    const float corners[9] = {-9, -9, 0, 9, -9, 0, 0, 9, 0};
    folder.write("s.gltf", kTriangle);
    folder.write("s.bin", std::as_bytes(std::span(corners)));
    folder.write("t.png", "a texture");
    folder.write("e.exr", exrPanorama(16, 8));
  }
  Outcome run(std::vector<std::string> arguments) const {
    return latelight({.arguments = std::move(arguments), .folder = folder.path()});
  }
  Outcome render(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render", "--size", "32x18", "--device", "cpu"});
    return run(std::move(arguments));
  }
  // Runs the program in a shell command; "$0" is its path.
  Outcome shell(const std::string& command) const {
    return runProcess("/bin/sh", {.arguments = {"-c", command, LATELIGHT_PROGRAM}, .folder = folder.path()});
  }
  void expectRefused(const Outcome& outcome, const std::string& says, int code = kUsage) const {
    EXPECT_EQ(outcome.code, code) << outcome.text();
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(StartsWith("latelight: "), HasSubstr(says)));
    EXPECT_EQ(outcome.out, "");
  }
  int modeOf(const char* name) const { return static_cast<int>(fs::status(folder.path() / name).permissions()); }
  Folder folder;
};

// --- outputs, inputs, and files at their paths ----------------------------------------------------------------------

TEST_F(Places, NothingThatIsReadIsWrittenOver) {
  fs::create_symlink("s.gltf", folder.path() / "link.dot");
  ASSERT_EQ(render({"builtin:boxes", "-o", "a.png"}).code, 0);
  const std::vector<std::string> names = folder.names();
  std::map<std::string, std::string> before;
  for (const std::string& name : names) before[name] = folder.read(name);
  const char* says = "this command reads it";
  for (const char* graph : {"s.gltf", "./s.gltf", "link.dot", "s.bin", "t.png", "e.exr"})
    expectRefused(render({"s.gltf", "-o", "b.png", "--hdri", "e.exr", "--dump-graph", graph}), says);
  expectRefused(render({"s.gltf", "-o", "t.png"}), says);
  expectRefused(render({"s.gltf", "-o", "t.png", "--debug", "depth"}), says);
  expectRefused(render({"builtin:boxes", "--hdri", "e.exr", "-o", "e.exr"}), says);
  expectRefused(run({"compare", "a.png", "a.png", "--diff", "a.png"}), says);
  EXPECT_EQ(folder.names(), names);
  for (const auto& [name, bytes] : before) EXPECT_EQ(folder.read(name), bytes) << name;
}

TEST_F(Places, TwoOutputsOfOneNameAreWrongUse) {
  const std::vector<std::string> names = folder.names();
  fs::create_symlink("y.png", folder.path() / "x.png");
  folder.write("y.png", "old");
  expectRefused(render({"s.gltf", "-o", "z.png", "--dump-graph", "z.png"}), "'z.png'");
  expectRefused(render({"s.gltf", "-o", "x.png", "--dump-graph", "y.png"}), "the same file");
  expectRefused(render({"s.gltf", "-o", "z.exr", "--aov", "depth", "--dump-graph", "z.json"}), "'z.json'");
  expectRefused(render({"s.gltf", "-o", "z.png", "--aov", "color,depth", "--dump-graph", "z.depth.png"}),
                "z.depth.png");
  expectRefused(render({"s.gltf", "-o", "{scene}.{frame}.png", "--frames", "0-9", "--dump-graph", "s.0007.png"}),
                "'s.0007.png'");
  EXPECT_EQ(folder.read("y.png"), "old");
  EXPECT_EQ(folder.names().size(), names.size() + 2);
}

TEST_F(Places, PipesNeedReaders) {
  ASSERT_EQ(mkfifo((folder.path() / "p.png").c_str(), 0600), 0);
  expectRefused(render({"builtin:boxes", "-o", "p.png"}), "without a reader");
  const Outcome read = shell("cat p.png & \"$0\" render builtin:boxes --size 32x18 --device cpu -o p.png && wait");
  EXPECT_EQ(read.code, 0) << read.text();
  EXPECT_THAT(read.out, StartsWith(kPng));
}

TEST_F(Places, WhatIsReplacedKeepsItsModeAndMayRefuse) {
  for (const char* name : {"a.png", "b.png"}) folder.write(name, "old");
  chmod((folder.path() / "a.png").c_str(), 0600);
  chmod((folder.path() / "b.png").c_str(), 0444);
  EXPECT_EQ(render({"builtin:boxes", "-o", "a.png"}).code, 0);
  EXPECT_THAT(folder.read("a.png"), StartsWith(kPng));
  EXPECT_EQ(modeOf("a.png"), 0600);
  expectRefused(render({"builtin:boxes", "-o", "b.png"}), "read-only");
  expectRefused(render({"builtin:boxes", "-o", "a.png", "--dump-graph", "b.png"}), "read-only");
  expectRefused(run({"compare", "a.png", "a.png", "--diff", "b.png"}), "read-only");
  EXPECT_EQ(folder.read("b.png"), "old");
}

TEST_F(Places, LinksAreFollowedToWhatIsThere) {
  folder.write("old.png", "old");
  fs::create_symlink("old.png", folder.path() / "good.png");
  fs::create_symlink("gone.png", folder.path() / "dangling.png");
  const std::vector<std::string> names = folder.names();
  EXPECT_EQ(render({"builtin:boxes", "-o", "good.png"}).code, 0);
  EXPECT_THAT(folder.read("old.png"), StartsWith(kPng));
  EXPECT_TRUE(fs::is_symlink(folder.path() / "good.png"));
  expectRefused(render({"builtin:boxes", "-o", "dangling.png"}), "'gone.png', which does not exist");
  EXPECT_EQ(folder.names(), names);
  fs::create_symlink("circle.png", folder.path() / "circle.png");
  expectRefused(render({"builtin:boxes", "-o", "circle.png"}), "in a circle");
  EXPECT_TRUE(fs::is_symlink(folder.path() / "circle.png"));
}

TEST_F(Places, StudiesFindOutBeforehandWhetherTheyMayWrite) {
  const std::vector<std::string> names = folder.names();
  const auto study = [&](const char* out) { return run({"study", "depth", "--device", "cpu", "-o", out}); };
  expectRefused(study("/proc/study"), "/proc/study");
  expectRefused(study("/proc"), "/proc");
  expectRefused(study("s.bin"), "no folder");
  expectRefused(study("no/such"), "no/such");
  // The run produces no file, so its folder is removed again.
  expectRefused(run({"study", "depth", "--device", "5", "-o", "new"}), "\"5\"", kNoDevice);
  EXPECT_EQ(folder.names(), names);
  fs::create_directory(folder.path() / "old");
  folder.write("old/depth.csv", "mine");
  chmod((folder.path() / "old/depth.csv").c_str(), 0444);
  expectRefused(study("old"), "read-only");
  EXPECT_EQ(folder.read("old/depth.csv"), "mine");
}

// --- streams, disks and termination ---------------------------------------------------------------------------------

TEST_F(Places, ErrorsThatCannotBeWrittenKeepTheirCode) {
  EXPECT_EQ(shell("exec \"$0\" render none.glb -o a.png 2>/dev/full").code, kBadInput);
  EXPECT_EQ(shell("exec \"$0\" render none.glb -o a.png 2>&-").code, kBadInput);
  EXPECT_EQ(shell("exec \"$0\" render --nothing 2>/dev/full").code, kUsage);
  EXPECT_EQ(shell("exec \"$0\" list >&- 2>&-").code, kUsage);
  EXPECT_EQ(shell("exec \"$0\" list >/dev/full 2>/dev/full").code, kUsage);
  EXPECT_EQ(shell("ulimit -f 0; exec \"$0\" render none.glb -o a.png 2>errors").code, kBadInput);
  EXPECT_EQ(shell("ulimit -f 0; exec \"$0\" list >out 2>errors").code, kUsage);
  expectRefused(shell("exec \"$0\" list >&-"), "standard output");
}

// Otherwise the first file that is opened would get the descriptor of a closed stream and receive the program's
// messages.
TEST_F(Places, ClosedStreamsGetIntoNoFile) {
  const Outcome outcome =
      shell("exec \"$0\" render s.gltf -o a.png --size 32x18 --device cpu --hdri nothing <&- >&- 2>&-");
  EXPECT_EQ(outcome.code, kBadInput);
  const Outcome picked =
      shell("exec \"$0\" render s.gltf -o a.png --pick 9,9 --hdri none --size 32x18 --device cpu <&- >&- 2>&-");
  EXPECT_EQ(picked.code, kUsage) << "what --pick says can't be said";
  EXPECT_EQ(render({"s.gltf", "-o", "b.png", "--hdri", "none"}).code, 0);
  EXPECT_EQ(folder.read("a.png"), folder.read("b.png"));
}

// As with any program whose output goes to head, the signal is the report, without a message.
TEST_F(Places, ReadersOfTextMayLeave) {
  const Outcome outcome = shell("mkfifo p; exec 3<>p 4>p 3<&-; \"$0\" list >&4; echo $? >code");
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(folder.read("code"), std::to_string(128 + SIGPIPE) + "\n");
}

// The driver maps a sparse index file into memory. Writing to it on a full disk used to end the program with SIGBUS.
TEST_F(Places, AFullDiskOfTheDriversCacheIsNotTheEnd) {
  const test::SmallDisk disk(16u << 10);
  if (!disk) GTEST_SKIP() << "This user may not mount a small disk.";
  disk.fill();
  const Outcome outcome =
      latelight({.arguments = {"render", "s.gltf", "-o", "a.png", "--size", "32x18", "--device", "cpu"},
                 .environment = {{"MESA_SHADER_CACHE_DIR", disk.path().string()}},
                 .folder = folder.path()});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(outcome.err, AllOf(StartsWith("warning: "), HasSubstr("is full"), HasSubstr(disk.path().string())));
  EXPECT_THAT(folder.read("a.png"), StartsWith(kPng));
}

// There is nothing to free in a file system without storage.
TEST_F(Places, ACacheThatCannotBeCreatedIsNoFullDisk) {
  const Outcome outcome =
      latelight({.arguments = {"render", "s.gltf", "-o", "a.png", "--size", "32x18", "--device", "cpu"},
                 .environment = {{"MESA_SHADER_CACHE_DIR", ""}, {"XDG_CACHE_HOME", "/proc/nope"}},
                 .folder = folder.path()});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(outcome.err,
            "warning: the folder '/proc/nope/mesa_shader_cache' cannot be created, so the shader cache of Mesa's "
            "drivers is disabled for this run; set XDG_CACHE_HOME to a folder that can be written to\n");
}

TEST_F(Places, AFullDiskOfThePictureIsASentence) {
  const test::SmallDisk disk(16u << 10);
  if (!disk) GTEST_SKIP() << "This user may not mount a small disk.";
  disk.fill();
  expectRefused(render({"s.gltf", "-o", (disk.path() / "a.exr").string()}), "No space left");
  EXPECT_EQ(std::distance(fs::directory_iterator(disk.path()), fs::directory_iterator()), 1);
}

// A run of many frames that is terminated at some time after its first file was written.
int endedBy(int signal, const Folder& folder, unsigned microseconds) {
  const std::string out = folder.at("{frame}.{aov}.npy");
  const char* arguments[] = {LATELIGHT_PROGRAM, "render", "builtin:boxes", "--size",  "64x36",
                             "--device",        "cpu",    "--frames",      "0-99999", "--aov",
                             "depth,normal",    "-o",     out.c_str(),     nullptr};
  pid_t process = 0;
  if (posix_spawn(&process, LATELIGHT_PROGRAM, nullptr, nullptr, const_cast<char**>(arguments), environ) != 0)
    return -1;
  int status = 0;
  while (!fs::exists(folder.path() / "00000.depth.npy") && waitpid(process, &status, WNOHANG) == 0) usleep(1000);
  usleep(microseconds);
  kill(process, signal);
  return waitpid(process, &status, 0) == process && WIFSIGNALED(status) ? WTERMSIG(status) : -1;
}

// temporary_file_test.cpp covers the times in between.
TEST_F(Places, SignalsLeaveWholeFilesOnly) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Folder frames;
    EXPECT_EQ(endedBy(signal, frames, 7919), signal);
    EXPECT_FALSE(frames.names().empty());
    for (const std::string& name : frames.names()) EXPECT_FALSE(name.starts_with('.')) << name;
  }
}

// --- limits of the system -------------------------------------------------------------------------------------------

// Mesa waits forever for threads that it could not start. Root is exempt from the limit, so as root, the test runs the
// program as a user without other processes. The limits are below and above the numbers of threads that are chosen.
TEST_F(Places, TooFewThreadsForTheCpuDeviceAreASentence) {
  const bool isRoot = geteuid() == 0;
  if (isRoot) chmod(folder.path().c_str(), 0777);
  const auto limited = [&](int processes, const std::string& arguments) {
    const std::string run = fmt::format("ulimit -u {}; exec '{}' {}", processes, LATELIGHT_PROGRAM, arguments);
    std::vector<std::string> shell{"/bin/bash", "-c", run};
    if (isRoot) shell.insert(shell.begin(), {"/usr/bin/setpriv", "--reuid=54321", "--regid=54321", "--clear-groups"});
    return runProcess(shell[0], {.arguments = {shell.begin() + 1, shell.end()},
                                 .environment = {{"LP_NUM_THREADS", "2"},
                                                 {"LATELIGHT_THREADS", "2"},
                                                 {"XDG_CACHE_HOME", folder.path().string()}},
                                 .folder = folder.path(),
                                 .timeout = std::chrono::minutes(5)});
  };
  const std::string render = "render builtin:boxes --size 32x18 --device cpu -o a.png";
  if (isRoot && (!fs::exists("/usr/bin/setpriv") || limited(200, "--version").code != 0))
    GTEST_SKIP() << "The program cannot run as another user.";
  for (const int processes : isRoot ? std::vector{1, 3, 5, 6, 7} : std::vector{1}) {
    SCOPED_TRACE(processes);
    expectRefused(limited(processes, render), "raise `ulimit -u`", kNoDevice);
    const Outcome doctor = limited(processes, "doctor");
    EXPECT_EQ(doctor.code, kNoDevice) << doctor.text();
    EXPECT_THAT(doctor.out, AllOf(HasSubstr("problem The CPU device requires"), HasSubstr("        Raise `ulimit -u`"),
                                  HasSubstr("cannot render on this machine yet")));
  }
  EXPECT_FALSE(fs::exists(folder.path() / "a.png"));
  if (!isRoot) return;
  const Outcome outcome = limited(200, render);
  EXPECT_EQ(outcome.code, 0) << outcome.text();
}

TEST_F(Places, TooFewOpenFilesAreASentence) {
  for (const int files : {5, 8}) {
    expectRefused(shell(fmt::format("ulimit -n {}; exec \"$0\" render builtin:boxes --device cpu -o a.png", files)),
                  "raise `ulimit -n`", kNoDevice);
    const Outcome doctor = shell(fmt::format("ulimit -n {}; exec \"$0\" doctor", files));
    EXPECT_EQ(doctor.code, kNoDevice) << doctor.text();
    EXPECT_THAT(doctor.out, AllOf(HasSubstr("        Raise `ulimit -n`"), Not(HasSubstr("apt-get"))));
  }
}

TEST_F(Places, ANumberOfThreadsOutOfItsRangeIsIgnoredWithAWarning) {
  for (const char* threads : {"0", "1025", "many"}) {
    const Outcome outcome =
        latelight({.arguments = {"render", "builtin:boxes", "-o", "a.png", "--size", "32x18", "--device", "cpu"},
                   .environment = {{"LATELIGHT_THREADS", threads}},
                   .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_EQ(outcome.err, fmt::format("warning: LATELIGHT_THREADS is '{}', which is not a number of threads, and is "
                                       "ignored: use a number from 1 to 1024\n",
                                       threads));
  }
}

TEST_F(Places, AFolderOfShadersHasSome) {
  const std::vector<std::string> command{"bench", "frame", "builtin:boxes", "--device", "cpu", "--shaders", "shaders"};
  expectRefused(run(command), "no folder shaders", kBadInput);
  fs::create_directory(folder.path() / "shaders");
  folder.write("shaders/mine.comp.spv", "mine");
  expectRefused(run(command), "folder shaders has none of the program's shaders", kBadInput);
}

// --- names and arguments --------------------------------------------------------------------------------------------

TEST_F(Places, PickedNamesDoNotActOnTerminals) {
  const Outcome text = render({"s.gltf", "--pick", "16,9"});
  EXPECT_EQ(text.code, 0) << text.text();
  EXPECT_THAT(text.out, AllOf(HasSubstr("?[2J??x\n"), Not(HasSubstr("\x1b"))));
  const nlohmann::json report = nlohmann::json::parse(render({"s.gltf", "--pick", "16,9", "--json"}).out);
  EXPECT_THAT(report["picked"][0]["node"].get<std::string>(), HasSubstr("\x1b[2J\n"));
}

TEST_F(Places, PathsNeedNotBeUtf8) {
  fs::copy_file(folder.path() / "s.gltf", folder.path() / "\xff.gltf");
  const Outcome outcome = render({"\xff.gltf", "-o", "a\xff.exr", "--aov", "depth", "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["files"].size(), 2u);
  EXPECT_TRUE(fs::exists(folder.path() / "a\xff.exr"));
  EXPECT_FALSE(nlohmann::json::parse(folder.read("a\xff.json")).empty());
}

TEST_F(Places, LongOptionsHaveTwoDashes) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"-hdri", "x"},
                                             {"render", "-hdri", "x"},
                                             {"render", "-hdri=x"},
                                             {"render", "builtin:boxes", "-o", "a.png", "-size", "32x18"},
                                             {"render", "builtin:boxes", "-out", "a.png"},
                                             {"study", "-help"},
                                             {"list", "-hurry"}})
    expectRefused(run(arguments), arguments.size() > 1 && arguments[1] == "-hurry" ? "no option" : "two");
  EXPECT_EQ(run({"render", "-h"}).code, 0);
  EXPECT_EQ(run({"-qh"}).code, 0);
  EXPECT_EQ(run({"render", "s.gltf", "-qoa.png", "--hdri", "none", "--size", "32x18", "--device", "cpu"}).code, 0);
  EXPECT_THAT(folder.read("a.png"), StartsWith(kPng));
  // An option's value may look like an option if a value is expected.
  expectRefused(run({"render", "s.gltf", "-o", "b.png", "--variant", "-hdri"}), "-hdri");
}

TEST_F(Places, ValuesAreNotEmpty) {
  for (const char* list : {"--lights", "--triangles", "--sizes", "--bits"}) {
    expectRefused(run({"study", list[2] == 'b' ? "normals" : "lights", "--device", "cpu", list, ""}), list);
    expectRefused(run({"study", list[2] == 'b' ? "normals" : "lights", "--device", "cpu", list, ","}), list);
  }
  for (const char* option : {"--aov", "--hdri", "--debug", "--eye", "--frames", "--dump-graph", "--variant"})
    expectRefused(render({"builtin:boxes", "-o", "a.png", option, ""}), option);
}

TEST_F(Places, LongArgumentsAreNotRepeatedWhole) {
  const std::string text(5000, 'a');
  const std::vector<std::string> good{"render", "builtin:boxes", "-o", "a.png"};
  std::vector<std::vector<std::string>> wrong{{text},
                                              {"list", text},
                                              {"study", text},
                                              {"compare", text, text},
                                              {"render", text, "-o", "a.png"},
                                              {"render", "builtin:" + text, "-o", "a.png"},
                                              {"render", "builtin:boxes", "-o", text + ".png"},
                                              {"render", "builtin:boxes", "-o", text},
                                              {"study", "lights", "--lights", text}};
  for (const char* option :
       {"--size",   "--camera",    "--eye",          "--orbit",    "--fov",     "--frame",      "--time",
        "--frames", "--animation", "--turn",         "--layout",   "--normals", "--lighting",   "--shadow-lights",
        "--sun",    "--aa",        "--hdri",         "--exposure", "--tonemap", "--background", "--aov",
        "--pick",   "--debug",     "--normal-frame", "--axes",     "--device",  "--nothing"}) {
    wrong.push_back(good);
    wrong.back().insert(wrong.back().end(), {option, text});
    wrong.push_back(good);
    wrong.back().push_back(option + ("=" + text));
  }
  std::vector<Outcome> outcomes(wrong.size());
  inPairs(wrong.size(), [&](size_t i) { outcomes[i] = run(wrong[i]); });
  for (size_t i = 0; i < wrong.size(); ++i) {
    EXPECT_TRUE(outcomes[i].code >= kUsage && outcomes[i].code <= kNoDevice) << outcomes[i].text();
    EXPECT_LT(outcomes[i].err.size(), 1200u) << outcomes[i].err;
    EXPECT_EQ(std::count(outcomes[i].err.begin(), outcomes[i].err.end(), '\n'), 1) << outcomes[i].err;
  }
}

TEST_F(Places, ANumberIsADevicesIndexAndNoPartOfItsName) {
  // The name of the CPU device contains its LLVM version and "256 bits".
  for (const char* number : {"5", "256", "15"})
    expectRefused(run({"render", "builtin:boxes", "-o", "a.png", "--device", number}), number, kNoDevice);
}

}  // namespace
}  // namespace latelight::app
