// Creates and compares data sets for tests.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/folder.h"
#include "app/process.h"

namespace latelight::data {

// The smallest scene that a camera can see.
inline constexpr const char* kCameraAlone =
    R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]})";

inline constexpr const char* kOrthographicCamera =
    R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}}]})";

// Options for tiny frames on the CPU device.
inline app::Command batch(const app::Folder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "batch");
  for (const char* more : {"--devices", "cpu", "--size", "32x24"}) arguments.emplace_back(more);
  return {.arguments = std::move(arguments), .folder = folder.path()};
}

// Returns the files of a set by name, except those that describe its creation. Files that are being written have
// another name and are not included.
inline std::map<std::string, std::string> filesOf(const app::Folder& folder, const std::string& set) {
  std::map<std::string, std::string> files;
  std::error_code ignored;
  for (std::filesystem::recursive_directory_iterator entry(folder.path() / set, ignored), end; entry != end; ++entry) {
    const std::string name = entry->path().lexically_relative(folder.path() / set).string();
    if (entry->is_regular_file() && !entry->path().filename().string().starts_with('.') &&
        !name.starts_with(".latelight/"))
      files[name] = folder.read(set + "/" + name);
  }
  return files;
}

// Expects that every file of the set equals that of the other set, so that none is incomplete.
inline void expectPartOf(const std::map<std::string, std::string>& part,
                         const std::map<std::string, std::string>& all) {
  for (const auto& [name, bytes] : part) {
    const auto found = all.find(name);
    ASSERT_NE(found, all.end()) << name;
    EXPECT_TRUE(found->second == bytes) << name << " is torn";
  }
}

inline void expectSame(const std::map<std::string, std::string>& set, const std::map<std::string, std::string>& other) {
  expectPartOf(set, other);
  EXPECT_EQ(set.size(), other.size());
}

}  // namespace latelight::data
