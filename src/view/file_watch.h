// Polls files on disk for changes.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <vector>

namespace latelight::view {

class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kSeconds = 0.5;  // seconds between two checks

  void watch(const std::vector<std::filesystem::path>& files);
  // Checks the files at most twice per second. Returns true once a change is complete, that is, after two checks with
  // the same new times.
  bool changed();

 private:
  using Times = std::vector<std::optional<std::filesystem::file_time_type>>;  // empty: the file does not exist
  Times times() const;

  std::vector<std::filesystem::path> files_;
  Times known_, seen_;
  Clock::time_point checkedAt_{};
};

}  // namespace latelight::view
