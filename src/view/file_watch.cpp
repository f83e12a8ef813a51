#include "view/file_watch.h"

#include <system_error>
#include <utility>

namespace latelight::view {

namespace {

std::optional<std::filesystem::file_time_type> timeOf(const std::filesystem::path& file) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error);
  return error ? std::nullopt : std::optional(time);
}

}  // namespace

void FileWatch::add(const std::filesystem::path& file) {
  if (files_.contains(file)) return;
  const Time time = timeOf(file);
  files_.emplace(file, Times{time, time});
}

void FileWatch::add(const FileWatch& other) {
  for (const auto& [file, times] : other.files_) {
    const auto [mine, isAdded] = files_.try_emplace(file, times);
    if (!isAdded && !times.known) mine->second.known.reset();
  }
}

bool FileWatch::changed() {
  const auto now = Clock::now();
  if (files_.empty() || std::chrono::duration<double>(now - checkedAt_).count() < kSeconds) return false;
  checkedAt_ = now;
  bool isStable = true, isNew = false;
  for (auto& [file, times] : files_) {
    const Time time = timeOf(file);
    isStable &= std::exchange(times.seen, time) == time;
    isNew |= time && time != times.known;
  }
  if (!isStable || !isNew) return false;
  for (auto& [file, times] : files_) times.known = times.seen;
  return true;
}

}  // namespace latelight::view
