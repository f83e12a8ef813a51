// Tracks the files that a command reads and writes, so that it never overwrites its inputs or its other outputs.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

namespace latelight::output {

class UsedFiles {
 public:
  explicit UsedFiles(std::span<const std::filesystem::path> inputs);

  // Throws Error(Usage) if an output is an input, through any name or link, or if two outputs are the same file. "-",
  // an empty name and devices do not count as files.
  void checkOutputs(std::span<const std::filesystem::path> outputs);

 private:
  std::string entryOf(const std::filesystem::path& path);

  std::map<std::string, std::string> folders_;  // identities of folders, by name
  std::set<std::string> entries_;               // inputs: folder and name
  std::set<std::pair<uint64_t, uint64_t>> inodes_;
};

}  // namespace latelight::output
