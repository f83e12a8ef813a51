// Whether files have changed on disk.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <vector>

namespace latelight::view {

class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kSeconds = 0.5;  // between two looks

  void watch(const std::vector<std::filesystem::path>& files);
  // Looks at most twice a second. True once a change is complete: two looks see the same new times.
  bool changed();

 private:
  using Times = std::vector<std::optional<std::filesystem::file_time_type>>;  // nothing: it is not there
  Times times() const;

  std::vector<std::filesystem::path> files_;
  Times known_, seen_;
  Clock::time_point looked_{};
};

}  // namespace latelight::view
