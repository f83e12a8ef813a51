#include "base/write.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.h"

namespace latelight {

int writeAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    // A short write has no reason. The write of the remaining bytes returns it, such as EFBIG or ENOSPC.
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return 0;
}

void failToWrite(const std::filesystem::path& path, int error) {
  const char* advice = "choose a place that can be written to";
  if (error == ENOENT || error == ENOTDIR) advice = "make its folder first, or choose another";
  if (error == ENOSPC || error == EDQUOT) advice = "free some space there, or choose another place";
  if (error == EFBIG) advice = "raise the file size limit (ulimit -f), or choose another place";
  if (error == ELOOP) advice = "its links lead in a circle: remove them, or choose another place";
  badUsage("can't write '{}': {}; {}", path.string(), std::generic_category().message(error), advice);
}

}  // namespace latelight
