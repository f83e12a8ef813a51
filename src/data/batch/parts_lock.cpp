#include "data/batch/parts_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "base/write.h"

namespace latelight::data {

namespace {

bool lockFile(int fd, int operation) {
  while (flock(fd, operation) != 0)
    if (errno != EINTR) return false;
  return true;
}

// Replaces the contents of the file, which this process has locked exclusively.
void storeParts(int fd, const std::filesystem::path& file, const std::string& parts) {
  if (ftruncate(fd, 0) != 0) failToWrite(file, errno);
  if (const int error = writeAll(fd, std::as_bytes(std::span(parts)))) failToWrite(file, error);
}

std::string readParts(int fd) {
  char text[16];
  const ssize_t bytes = pread(fd, text, sizeof(text), 0);
  return {text, static_cast<size_t>(bytes > 0 ? bytes : 0)};
}

}  // namespace

PartsLock::PartsLock(const std::filesystem::path& file, uint32_t parts)
    : fd_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (fd_ < 0)
    badUsage("can't write to '{}': {}; make its folder writable, or choose another", file.string(),
             std::strerror(errno));
  try {
    const std::string own = std::to_string(parts);
    // Only the first process can lock the file exclusively.
    if (lockFile(fd_, LOCK_EX | LOCK_NB))
      storeParts(fd_, file, own);
    else if (errno != EWOULDBLOCK)
      return;
    // Linux releases the exclusive lock before it grants the shared one, so another process may store its number in
    // between. Under the shared lock the number is final.
    if (!lockFile(fd_, LOCK_SH)) return;
    if (const std::string other = readParts(fd_); other != own)
      badUsage(
          "another process is rendering '{}' in {} parts, and this one would in {}: wait for it, end it, or use "
          "--shard i/{}",
          file.parent_path().parent_path().string(), other, own, other);
  } catch (...) {
    close(fd_);
    throw;
  }
}

PartsLock::~PartsLock() {
  close(fd_);
}

}  // namespace latelight::data
