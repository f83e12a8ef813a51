// The walls between modules: each is compiled with an include folder that leads only to what it may include
// (cmake/modules.cmake). These tests include files as the sources of a module do, so the walls cannot fall unnoticed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "architecture/command.h"

namespace latelight {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kSource = fs::path(LATELIGHT_SOURCE_DIR) / "src";

// The folders in which a module's sources find their includes, as the build states them.
std::vector<fs::path> includeFolders(const std::string& module) {
  std::ifstream file(fs::path(LATELIGHT_INCLUDE_DIRECTORIES) / (module + ".txt"));
  std::vector<fs::path> folders;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) folders.emplace_back(line);
  return folders;
}

Result include(const std::string& module, const std::string& header) {
  EXPECT_TRUE(fs::exists(kSource / header)) << header;
  std::string command = "echo '#include \"" + header + "\"' | '" LATELIGHT_CXX "' -std=c++20 -fsyntax-only";
  for (const fs::path& folder : includeFolders(module)) command += " -I'" + folder.string() + "'";
  return runCommand(command + " -x c++ -");
}

TEST(Walls, LetModulesIncludeWhatTheyUse) {
  for (const auto& [module, header] : std::vector<std::pair<const char*, const char*>>{
           {"latelight_render_base", "vk/constant_id.h"},
           {"latelight_render_passes", "render/lens/lens_push.h"},
           {"latelight_render_submit", "render/options/options.h"},
           {"latelight_scene", "scene/image_size.h"},
           {"latelight_scene_load", "scene/gltf/load.h"},
           {"latelight_program", "base/text.h"},
       }) {
    const Result result = include(module, header);
    EXPECT_TRUE(result.good) << module << " cannot include " << header << ":\n" << result.output;
  }
}

TEST(Walls, StopWhatIsAboveOrBeside) {
  for (const auto& [module, header] : std::vector<std::pair<const char*, const char*>>{
           {"latelight_base", "shared/types.h"},
           {"latelight_vk", "graph/graph.h"},
           {"latelight_graph", "render/base/pass.h"},
           {"latelight_scene", "vk/device.h"},
           {"latelight_scene", "scene/gltf/load.h"},
           {"latelight_scene_textures", "scene/environment/environment.h"},
           {"latelight_scene_gltf", "scene/load/load.h"},
           {"latelight_output", "render/settings/settings.h"},
           {"latelight_render_base", "render/frame/frame.h"},
           {"latelight_render_gpu_scene", "render/frame/frame.h"},
           {"latelight_render_settings", "render/lighting/technique.h"},
           {"latelight_render_frame", "render/visibility/visibility.h"},
           {"latelight_render_outputs", "render/shadow/frame_shadows.h"},
           {"latelight_render_passes", "render/post/post.h"},
           {"latelight_render_passes", "render/submit/renderer.h"},
           {"latelight_render_submit", "study/study.h"},
           {"latelight_data", "study/study.h"},
           {"latelight_program", "api/scene.h"},
       }) {
    const Result result = include(module, header);
    EXPECT_FALSE(result.good) << module << " can include " << header;
    EXPECT_THAT(result.output, testing::AnyOf(HasSubstr("No such file"), HasSubstr("file not found")));
  }
}

// A module that also saw src as a whole, or a folder of it that holds other modules, would have no walls.
TEST(Walls, StandAroundEveryModule) {
  std::set<std::string> modules;
  for (const fs::directory_entry& entry : fs::directory_iterator(LATELIGHT_INCLUDE_DIRECTORIES))
    modules.insert(entry.path().stem().string());
  ASSERT_GT(modules.size(), 20u);
  for (const std::string& module : modules) {
    const std::vector<fs::path> folders = includeFolders(module);
    EXPECT_THAT(folders, testing::Not(IsEmpty())) << module;
    for (const fs::path& folder : folders) {
      EXPECT_FALSE(fs::equivalent(folder, kSource)) << module;
      EXPECT_FALSE(fs::equivalent(folder, kSource.parent_path())) << module;
      for (const char* parent : {"render", "scene"})
        EXPECT_FALSE(fs::is_symlink(folder / parent)) << module << " sees all of " << parent;
    }
  }
}

}  // namespace
}  // namespace latelight
