#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
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

TEST(IncludeRules, CatchVulkanAndUnclearPaths) {
  const auto wrong = [](std::string_view folder, std::string_view text) {
    return wrongIncludes(folder, text, nothingGenerated);
  };
  EXPECT_THAT(wrong("include", "#include <volk.h>\n"), ElementsAre("volk.h (Vulkan)"));
  EXPECT_THAT(wrong("scene", "#include <vulkan/vulkan.h>\n"), ElementsAre("vulkan/vulkan.h (Vulkan)"));
  EXPECT_THAT(wrong("graph", "// text\n  #  include \"use.h\""), testing::SizeIs(1));
  EXPECT_THAT(wrong("render", "#include \"../submit/renderer.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(wrong("render", "#include \"render/frame/../submit/renderer.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(wrong("render", "#include <volk.h>\n#include \"graph/graph.h\"\n// #include \"x.h\"\n"), IsEmpty());
}

TEST(IncludeRules, FindTheWayToVulkan) {
  const std::map<std::string, std::string> files = {
      {"a.h", "#include <vector>\n#include \"b.h\"\n#include \"c.h\"\n"},
      {"b.h", "#include \"a.h\"\n"},  // a cycle
      {"c.h", "#include <volk.h>\n"},
  };
  const auto textOf = [&](const std::string& path) { return files.contains(path) ? files.at(path) : std::string(); };
  EXPECT_THAT(wayToVulkan("#include \"a.h\"\n", textOf), ElementsAre("a.h", "c.h", "volk.h"));
  EXPECT_THAT(wayToVulkan("#include \"b.h\"\n",
                          [&](const std::string& path) { return path == "c.h" ? std::string() : textOf(path); }),
              IsEmpty());
}

bool isSource(const fs::path& path) {
  static const std::set<std::string> endings = {".h", ".cpp", ".glsl", ".vert", ".frag", ".comp", ".inc"};
  return endings.contains(path.extension().string());
}

std::string textOf(const fs::path& path) {
  if (!fs::is_regular_file(path)) return "";
  const std::vector<std::byte> bytes = readFile(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Files that the build writes, some of them once per layout in folders of their own.
std::set<std::string> generatedNames() {
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(LATELIGHT_GENERATED_DIR)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

// Checks the files under `root`, which belongs to `folder`. Returns their number.
size_t check(const fs::path& root, const std::string& folder) {
  static const std::set<std::string> generated = generatedNames();
  const auto isGenerated = [](const std::string& name) { return generated.contains(name); };
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file() || !isSource(entry.path())) continue;
    ++count;
    EXPECT_THAT(wrongIncludes(folder, textOf(entry.path()), isGenerated), IsEmpty()) << entry.path();
  }
  return count;
}

// However far away: what is below the renderer compiles on a machine without Vulkan, and so does a user of the API.
TEST(Includes, ComeToVulkanOnlyWhereItIsUsed) {
  const fs::path root = LATELIGHT_SOURCE_DIR;
  const auto included = [&](const std::string& path) {
    const std::string text = textOf(root / "src" / path);
    return text.empty() ? textOf(root / "include" / path) : text;
  };
  for (const char* folder : {"src/base", "src/shared", "src/scene", "src/output", "include"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      if (!entry.is_regular_file() || !isSource(entry.path())) continue;
      EXPECT_THAT(wayToVulkan(textOf(entry.path()), included), IsEmpty()) << entry.path();
    }
  }
}

TEST(Includes, AreClearAndKeepVulkanInItsFolders) {
  const fs::path source = LATELIGHT_SOURCE_DIR;
  for (const fs::directory_entry& folder : fs::directory_iterator(source / "src")) {
    EXPECT_GT(check(folder.path(), folder.path().filename().string()), 0u) << folder.path();
  }
  EXPECT_GT(check(source / "app", "app"), 0u);
  EXPECT_GT(check(source / "include", "include"), 0u);
}

}  // namespace
}  // namespace latelight
