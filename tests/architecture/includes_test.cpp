#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "architecture/include_rules.h"
#include "base/files.h"

namespace latelight {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

bool nothingGenerated(const std::string&) {
  return false;
}

TEST(IncludeRules, CatchWhatPointsTheWrongWay) {
  const auto wrong = [](std::string_view folder, std::string_view text) {
    return wrongIncludes(folder, text, nothingGenerated);
  };
  EXPECT_THAT(wrong("base", "#include \"vk/device.h\"\n"), ElementsAre("vk/device.h"));
  EXPECT_THAT(wrong("vk", "#include \"base/log.h\"\n#include \"graph/graph.h\"\n"), ElementsAre("graph/graph.h"));
  EXPECT_THAT(wrong("graph", "// text\n  #  include \"render/frame.h\""), ElementsAre("render/frame.h"));
  EXPECT_THAT(wrong("scene", "#include \"vk/resources.h\"\n"), ElementsAre("vk/resources.h"));
  EXPECT_THAT(wrong("shared", "#include \"base/error.h\"\n"), ElementsAre("base/error.h"));
  EXPECT_THAT(wrong("output", "#include \"scene/scene.h\"\n#include \"render/frame.h\"\n"),
              ElementsAre("render/frame.h"));
  EXPECT_THAT(wrong("render", "#include \"app/commands.h\"\n"), ElementsAre("app/commands.h"));
  EXPECT_THAT(wrong("render", "#include \"study/study.h\"\n"), ElementsAre("study/study.h"));
  EXPECT_THAT(wrong("study", "#include \"render/frame.h\"\n#include \"app/commands.h\"\n"),
              ElementsAre("app/commands.h"));
  EXPECT_THAT(wrong("include", "#include <volk.h>\n#include \"base/error.h\"\n"),
              ElementsAre("volk.h (Vulkan)", "base/error.h"));
  EXPECT_THAT(wrong("scene", "#include <vulkan/vulkan.h>\n"), ElementsAre("vulkan/vulkan.h (Vulkan)"));
  EXPECT_THAT(wrong("vk", "#include <latelight/latelight.h>\n"), ElementsAre("latelight/latelight.h"));
  EXPECT_THAT(wrong("graph", "#include \"use.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(wrong("somewhere", ""), testing::SizeIs(1));
  EXPECT_THAT(wrong("render", "#include <volk.h>\n#include \"graph/graph.h\"\n// #include \"app/x.h\"\n"), IsEmpty());
}

bool isSource(const fs::path& path) {
  static const std::set<std::string> endings = {".h", ".cpp", ".glsl", ".vert", ".frag", ".comp", ".inc"};
  return endings.contains(path.extension().string());
}

// What the build writes; some of it once a layout, in folders of their own.
std::set<std::string> generatedNames() {
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(LATELIGHT_GENERATED_DIR)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

// Checks the files under `root`, which lies in `folder`; gives how many there were.
size_t check(const fs::path& root, const std::string& folder) {
  static const std::set<std::string> generated = generatedNames();
  const auto isGenerated = [](const std::string& name) { return generated.contains(name); };
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file() || !isSource(entry.path())) continue;
    ++count;
    const std::vector<std::byte> bytes = readFile(entry.path());
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_THAT(wrongIncludes(folder, text, isGenerated), IsEmpty()) << entry.path();
  }
  return count;
}

TEST(Includes, PointTheRightWay) {
  const fs::path source = LATELIGHT_SOURCE_DIR;
  for (const fs::directory_entry& folder : fs::directory_iterator(source / "src")) {
    EXPECT_GT(check(folder.path(), folder.path().filename().string()), 0u) << folder.path();
  }
  EXPECT_GT(check(source / "app", "app"), 0u);
  EXPECT_GT(check(source / "include", "include"), 0u);
}

}  // namespace
}  // namespace latelight
