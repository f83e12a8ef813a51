#include "view/file_watch.h"

#include <algorithm>

namespace latelight::view {

void FileWatch::watch(const std::vector<std::filesystem::path>& files) {
  files_ = files;
  known_ = seen_ = times();
  checkedAt_ = Clock::now();
}

FileWatch::Times FileWatch::times() const {
  Times all;
  for (const std::filesystem::path& file : files_) {
    std::error_code error;
    const auto time = std::filesystem::last_write_time(file, error);
    all.push_back(error ? std::nullopt : std::optional(time));
  }
  return all;
}

bool FileWatch::changed() {
  const auto now = Clock::now();
  if (files_.empty() || std::chrono::duration<double>(now - checkedAt_).count() < kSeconds) return false;
  checkedAt_ = now;
  const Times earlier = std::exchange(seen_, times());
  const bool complete = seen_ == earlier && std::ranges::none_of(seen_, [](const auto& t) { return !t; });
  if (!complete || seen_ == known_) return false;
  known_ = seen_;
  return true;
}

}  // namespace latelight::view
