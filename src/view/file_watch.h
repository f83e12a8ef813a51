// Polls files on disk for changes.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>

namespace latelight::view {

class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kSeconds = 0.5;  // seconds between two checks

  // Watches a file, which need not exist, for changes from this call on. Call it before the file is read, so that a
  // change while it is read counts. A file that is already watched stays watched from its first call on.
  void add(const std::filesystem::path& file);
  // Watches the other watch's files too. Those that did not exist for it count as changed once they exist.
  void add(const FileWatch& other);
  // Checks the files at most twice per second. Returns true once a change is complete, that is, after two checks with
  // the same times of which that of an existing file is new. A deleted file is no change, since writers may be about to
  // replace it; one that appears is a change.
  bool changed();

 private:
  using Time = std::optional<std::filesystem::file_time_type>;  // empty: the file does not exist
  struct Times {
    Time known, seen;  // when the last change was complete, and at the last check
  };

  std::map<std::filesystem::path, Times> files_;
  Clock::time_point checkedAt_ = Clock::now();
};

}  // namespace latelight::view
