// The lock of the processes that render a data set at the same time. They must divide its frames into the same number
// of parts: parts of different numbers overlap, and the first process that completes the set would merge it and remove
// the files of the others.
#pragma once

#include <cstdint>
#include <filesystem>

namespace latelight::data {

class PartsLock {
 public:
  // `file` contains the number of parts while it is locked. Throws Error(Usage) if another process renders the set in
  // another number of parts. On file systems without locks, no lock is held.
  PartsLock(const std::filesystem::path& file, uint32_t parts);
  ~PartsLock();
  PartsLock(const PartsLock&) = delete;
  PartsLock& operator=(const PartsLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace latelight::data
