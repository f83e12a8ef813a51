#include "vk/driver_cache.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>

#include "base/log.h"

namespace latelight::vk {

namespace fs = std::filesystem;

namespace {

// Larger than Mesa's index of about 1.3 MB, because other processes may use up the space before the driver creates it.
constexpr uint64_t kMinFreeBytes = uint64_t{8} << 20;  // bytes

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// The folder that Mesa chooses; empty if it has none. Its default is in the user's home folder, regardless of HOME.
fs::path cacheFolder() {
  for (const char* name : {"MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR", "XDG_CACHE_HOME"})
    if (const std::string_view folder = variable(name); !folder.empty()) return fs::path(folder) / "mesa_shader_cache";
  const passwd* user = getpwuid(getuid());
  return user ? fs::path(user->pw_dir) / ".cache/mesa_shader_cache" : fs::path();
}

// Returns the status of the folder's disk, or nothing if it cannot be determined.
std::optional<struct statvfs> diskOf(fs::path folder) {
  struct statvfs status {};
  while (statvfs(folder.empty() ? "." : folder.c_str(), &status) != 0) {
    if (errno != ENOENT || folder.empty() || folder == folder.parent_path()) return std::nullopt;
    folder = folder.parent_path();
  }
  return status;
}

// Returns the free bytes on the folder's disk, or the maximum if they cannot be determined.
uint64_t freeBytesIn(const fs::path& folder) {
  const auto disk = diskOf(folder);
  return disk ? uint64_t{disk->f_bavail} * disk->f_frsize : UINT64_MAX;
}

// Returns false for file systems such as /proc, which have no blocks for files.
bool canStoreFiles(const fs::path& folder) {
  const auto disk = diskOf(folder);
  return !disk || disk->f_blocks > 0;
}

enum class Index { Missing, Whole, NoRoom };

Index fillIndex(const fs::path& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return Index::Missing;
  struct stat status {};
  Index index = Index::Missing;
  if (fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0) {
    index = Index::Whole;  // even if the file system cannot fill holes
    // Existing contents are kept, because other processes may be using them.
    if (status.st_blocks * 512 < status.st_size && fallocate(fd, 0, 0, status.st_size) != 0 &&
        (errno == ENOSPC || errno == EDQUOT))
      index = Index::NoRoom;
  }
  close(fd);
  return index;
}

}  // namespace

bool reserveDriverCache() {
  const fs::path folder = cacheFolder();
  if (folder.empty()) return true;
  const Index index = fillIndex(folder / "index");
  return index == Index::Missing ? freeBytesIn(folder) >= kMinFreeBytes : index == Index::Whole;
}

void avoidFullDriverCache() {
  constexpr const char* kOff = "MESA_SHADER_CACHE_DISABLE";
  if (variable(kOff) == "true" || variable(kOff) == "1" || reserveDriverCache()) return;
  setenv(kOff, "true", 1);
  if (canStoreFiles(cacheFolder()))
    warn(
        "the disk of '{}' is full, so the shader cache of Mesa's drivers is disabled for this run; free some space "
        "there",
        cacheFolder().string());
  else
    warn(
        "the folder '{}' cannot be created, so the shader cache of Mesa's drivers is disabled for this run; set "
        "XDG_CACHE_HOME to a folder that can be written to",
        cacheFolder().string());
}

}  // namespace latelight::vk
