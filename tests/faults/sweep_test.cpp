// One call after another fails: an allocation, a call on a file, or a Vulkan call. The command then ends with a
// promised exit code and one sentence or, if the failure does not matter to it, with its usual result. It writes only
// complete files, and the next run succeeds.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "lost_device/lose.h"

namespace latelight::app {
namespace {

using Names = std::vector<std::string>;
using Environment = std::map<std::string, std::string>;

struct Task {
  std::string name;
  Names arguments;
  // The files that the command may write. Each must equal that of an undisturbed run.
  Names files;
  // True for a data set, of which complete frames may remain.
  bool resumes = false;
};
void PrintTo(const Task& task, std::ostream* out) {
  *out << task.name;
}

constexpr const char* kScene = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "triangle.bin"}]})";

// Vertices (0, 0, 0), (1, 0, 0), (0, 1, 0).
std::string triangle() {
  std::string bytes(36, '\0');
  for (const size_t one : {12, 28}) bytes[one + 2] = '\x80', bytes[one + 3] = '\x3f';
  return bytes;
}

std::vector<Task> tasks() {
  const auto render = [](Names more) {
    Names all = {"render", "scene.gltf", "--size", "24x16", "--device", "cpu", "-o"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  return {{"png", render({"out.png"}), {"out.png"}},
          {"exr", render({"out.exr", "--aov", "depth,normal,id"}), {"out.exr"}},
          {"npy", render({"out.npy", "--aov", "depth", "--hdri", "sky.hdr"}), {"out.npy", "out_depth.npy"}},
          {"compare", {"compare", "a.png", "b.png", "--diff", "out.png"}, {"out.png"}},
          {"batch",
           {"batch", "--scenes", "scene.gltf", "--size", "24x16", "--cameras", R"({"type": "orbit", "count": 2})",
            "--formats", R"({"format": "files", "outputs": ["color"]})", "-o", "set"},
           {},
           true}};
}

void fillFolder(const Folder& folder, const Folder& images) {
  folder.write("scene.gltf", kScene);
  folder.write("triangle.bin", triangle());
  folder.write("sky.hdr",
               "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\nabc\x80"
               "def\x80");
  folder.write("a.png", images.read("a.png"));
  folder.write("b.png", images.read("b.png"));
}

class FaultSweep : public testing::TestWithParam<Task> {
 protected:
  static void SetUpTestSuite() {
    images = new Folder;
    for (const char* name : {"a.png", "b.png"})
      ASSERT_EQ(latelight({"render", "builtin:boxes", "--size", name[0] == 'a' ? "24x16" : "24x16", "--device", "cpu",
                           "--exposure", name[0] == 'a' ? "1" : "2", "-o", images->at(name)})
                    .code,
                0);
  }
  static void TearDownTestSuite() { delete images; }

  void SetUp() override {
    fillFolder(whole_, *images);
    const Outcome outcome = latelight(commandIn(whole_, {}));
    ASSERT_TRUE(outcome.code == 0 || GetParam().name == "compare") << outcome.text();
    code_ = outcome.code;
  }

  static Command commandIn(const Folder& folder, Environment environment) {
    environment.try_emplace("LATELIGHT_THREADS", "1");
    return {.arguments = GetParam().arguments, .environment = std::move(environment), .folder = folder.path()};
  }
  static Environment failing(const std::string& kind, uint64_t number, const Folder& folder) {
    return {{"LD_PRELOAD", LATELIGHT_FAULTS},
            {"LATELIGHT_FAULT", kind + " " + std::to_string(number)},
            {"LATELIGHT_FAULT_FOLDER", folder.path().string()},
            {"LATELIGHT_FAULT_COUNT", folder.path().string() + ".count"}};
  }

  // Returns the number of calls of an undisturbed run.
  uint64_t count(const std::string& kind) {
    const Folder folder;
    fillFolder(folder, *images);
    EXPECT_EQ(latelight(commandIn(folder, failing(kind, 0, folder))).code, code_);
    std::ifstream file(folder.path().string() + ".count");
    uint64_t calls = 0;
    file >> calls;
    std::filesystem::remove(folder.path().string() + ".count");
    return calls;
  }

  // Runs the command with a fault, and checks its exit code, message and files.
  void expectPromises(const std::function<Environment(const Folder&)>& environment, const std::set<int>& codes) {
    const Folder folder;
    fillFolder(folder, *images);
    const Outcome outcome = latelight(commandIn(folder, environment(folder)));
    std::filesystem::remove(folder.path().string() + ".count");
    ASSERT_TRUE(outcome.exited()) << outcome.text();
    EXPECT_TRUE(outcome.code == code_ || codes.contains(outcome.code)) << outcome.text();
    if (outcome.code != code_ && !GetParam().resumes) {
      EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
      EXPECT_TRUE(outcome.err.starts_with("latelight: ")) << outcome.err;
    }
    expectWholeFiles(folder, outcome);
  }

  void expectWholeFiles(const Folder& folder, const Outcome& outcome) {
    for (const std::string& name : folder.names()) {
      EXPECT_EQ(name.find("latelight-tmp"), name.npos) << name << " remains: " << outcome.text();
      const bool isSet = GetParam().resumes && name.starts_with("set/");
      const bool isImage = name.ends_with(".png") || name.ends_with(".exr") || name.ends_with(".npy");
      if (isImage) {
        EXPECT_TRUE(folder.read(name) == whole_.read(name)) << name << " differs: " << outcome.text();
      }
      if (!isSet && !std::ranges::count(GetParam().files, name)) {
        EXPECT_TRUE(std::filesystem::exists(whole_.at(name))) << name << " was not there: " << outcome.text();
      }
    }
    if (outcome.code != code_) return;
    for (const std::string& file : GetParam().files) EXPECT_TRUE(folder.read(file) == whole_.read(file)) << file;
  }

  // Calls body(number) for some of the numbers from 1 to `last`: all in long tests, else `usual` spread from the first
  // to the last.
  static void sweep(uint64_t last, uint64_t usual, const std::function<void(uint64_t)>& body) {
    std::set<uint64_t> numbers;
    const uint64_t steps = test::rounds(std::min<uint64_t>(last, 400), std::min(last, usual));
    for (uint64_t i = 0; i < steps; ++i) numbers.insert(1 + i * (last - 1) / std::max<uint64_t>(steps - 1, 1));
    const std::vector<uint64_t> all(numbers.begin(), numbers.end());
    inPairs(all.size(), [&](size_t i) {
      SCOPED_TRACE(all[i]);
      body(all[i]);
    });
  }

  static inline Folder* images = nullptr;
  const Folder whole_;
  int code_ = 0;
};

TEST_P(FaultSweep, Allocations) {
  const uint64_t calls = count("new");
  ASSERT_GT(calls, 100u);
  sweep(calls, 8, [&](uint64_t number) {
    expectPromises([&](const Folder& folder) { return failing("new", number, folder); }, {6, 7});
  });
}

// Each thread begins with a stack for its signal handlers, which it can do without. The first four allocations of its
// size are the stacks of the main thread and of others that begin together.
TEST_P(FaultSweep, StacksOfSignalHandlers) {
  if (GetParam().name == "compare") GTEST_SKIP() << "compare starts fewer threads";
  constexpr int kBytes = 64 << 10;
  for (int number = 1; number <= 4; ++number) {
    SCOPED_TRACE(number);
    expectPromises(
        [&](const Folder& folder) {
          Environment environment = failing("new", number, folder);
          environment["LATELIGHT_FAULT"] += fmt::format(" {}", kBytes);
          environment["LATELIGHT_THREADS"] = "3";
          return environment;
        },
        {});
  }
}

TEST_P(FaultSweep, Files) {
  for (const std::string kind : {"open", "read", "write", "close", "rename", "stat"}) {
    SCOPED_TRACE(kind);
    const uint64_t calls = count(kind);
    if (calls == 0) continue;
    sweep(calls, 2, [&](uint64_t number) {
      expectPromises([&](const Folder& folder) { return failing(kind, number, folder); }, {2, 3, 6});
    });
  }
}

TEST_P(FaultSweep, VulkanCalls) {
  if (GetParam().name == "compare") GTEST_SKIP() << "compare uses no device";
  for (const std::string name :
       {"vkAllocateMemory", "vkCreateBuffer", "vkCreateImage", "vkCreateImageView", "vkCreateComputePipelines",
        "vkCreateShaderModule", "vkCreateDescriptorPool", "vkAllocateDescriptorSets", "vkAllocateCommandBuffers",
        "vkQueueSubmit2", "vkWaitSemaphores", "vkMapMemory"}) {
    SCOPED_TRACE(name);
    for (const int number : test::runsAll() ? std::vector{1, 2, 3, 5, 8, 13, 21, 34} : std::vector{2})
      expectPromises([&](const Folder&) { return failingCall(name, number); }, {6, 7});
  }
}

// The commands without a device, whose only thread a child process can continue. JSON values are arrays and objects of
// sizeof(std::vector<int>) bytes: without their memory, nlohmann::json would destroy a value without contents.
TEST(FaultSweepTest, CommandsWithoutADeviceEndBySignalAtNoAllocation) {
  const Folder folder;
  const bool all = test::runsInFull();
  for (const Names& words : {Names{"batch", "--schema"}, Names{"export", "builtin:boxes", "-o", "out.glb"}}) {
    SCOPED_TRACE(words[0]);
    const Outcome outcome = latelight(
        {.arguments = words,
         .environment = {{"LATELIGHT_THREADS", "1"},
                         {"LD_PRELOAD", LATELIGHT_FAULTS},
                         {"LATELIGHT_FAULT", all ? "every 1 0" : fmt::format("every 5 {}", sizeof(std::vector<int>))},
                         {"LATELIGHT_FAULT_COUNT", folder.at("count")}},
         .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    std::istringstream counted(folder.read("count"));
    uint64_t calls = 0;
    counted >> calls;
    EXPECT_GT(calls, 20u);
    for (uint64_t number = 0; counted >> number;) ADD_FAILURE() << "a signal at allocation " << number;
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, FaultSweep, testing::ValuesIn(tasks()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace latelight::app
