#include "base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <system_error>

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"

namespace latelight {
namespace fs = std::filesystem;
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

class File {
 public:
  File(const fs::path& path, int flags) : fd_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~File() { close(); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  // 0 or an errno: on network file systems a full disk may show only here.
  int close() {
    const int result = fd_ >= 0 ? ::close(fd_) : 0;
    fd_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

// 0 or an errno.
int writeAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return 0;
}

// 0 or an errno. `size` is what the file says it has; pipes and files of /proc say 0.
int readAll(int fd, size_t size, std::vector<std::byte>& bytes) {
  constexpr size_t kChunk = size_t{1} << 16;
  bytes.resize(size);
  for (size_t filled = 0;;) {
    if (filled == bytes.size() && filled > size) bytes.resize(filled * 2);
    std::byte probe;  // at the stated size: usually the end, found without growing the vector
    const bool probing = filled == bytes.size();
    const ssize_t got = probing ? read(fd, &probe, 1) : read(fd, bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno;
    if (got == 0) {
      bytes.resize(filled);
      return 0;
    }
    if (probing) {
      bytes.resize(filled + kChunk);
      bytes[filled] = probe;
    }
    filled += static_cast<size_t>(got);
  }
}

[[noreturn]] void failToRead(const fs::path& path, const std::string& why) {
  badInput("can't read '{}': {}; check the path", path.string(), why);
}

[[noreturn]] void failToWrite(const fs::path& path, int error) {
  const char* advice = "choose a place that can be written to";
  if (error == ENOENT || error == ENOTDIR) advice = "make its folder first, or choose another";
  if (error == ENOSPC || error == EDQUOT) advice = "free some space there, or choose another place";
  if (error == EISDIR) advice = "give the name of a file";
  badUsage("can't write '{}': {}; {}", path.string(), reason(error), advice);
}

// A new file beside `path`; its name can't meet another's, nor one left by a process that was killed.
fs::path makeBeside(const fs::path& path, int& fd) {
  static std::atomic<unsigned> serial = 0;
  for (;;) {
    const fs::path beside =
        path.parent_path() / fmt::format(".{}.{}-{}.tmp", path.filename().string().substr(0, 200), getpid(), serial++);
    fd = open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) return beside;
  }
}

// 0 or an errno.
int replace(const fs::path& path, std::span<const std::byte> bytes) {
  int fd = -1;
  const fs::path beside = makeBeside(path, fd);
  if (fd < 0) return errno;
  int error = writeAll(fd, bytes);
  if (close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) unlink(beside.c_str());
  return error;
}

// 0 or an errno.
int writeWhole(const fs::path& path, std::span<const std::byte> bytes) {
  struct stat status {};
  const bool exists = stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return EISDIR;
  if (exists && !S_ISREG(status.st_mode)) {  // a pipe, /dev/null: there is nothing to rename over
    File file(path, O_WRONLY);
    if (!file) return errno;
    const int error = writeAll(file.get(), bytes);
    const int closing = file.close();
    return error ? error : closing;
  }
  // Through a symbolic link, so that the link stays.
  std::error_code ignored;
  const fs::path target = exists ? fs::canonical(path, ignored) : path;
  return replace(target.empty() ? path : target, bytes);
}

}  // namespace

std::vector<std::byte> readFile(const fs::path& path) {
  // O_NONBLOCK: opening a pipe that nobody writes to must not hang; it does nothing to regular files.
  File file(path, O_RDONLY | O_NONBLOCK);
  if (!file) failToRead(path, reason(errno));
  return readFile(file.get(), path);
}

std::vector<std::byte> readFile(int fd, const fs::path& path) {
  struct stat status {};
  if (fstat(fd, &status) != 0) failToRead(path, reason(errno));
  if (S_ISDIR(status.st_mode)) failToRead(path, "it is a folder, not a file");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode)) failToRead(path, "it is not a file");
  if (S_ISFIFO(status.st_mode)) fcntl(fd, F_SETFL, 0);
  // Asked for first: where memory is overcommitted, the allocation would succeed and the process be killed later.
  const auto size = static_cast<uint64_t>(status.st_size);
  const std::string what = fmt::format("the file '{}'", path.string());
  const MemoryClaim claim(size, what);
  try {
    std::vector<std::byte> bytes;
    if (const int error = readAll(fd, size, bytes)) failToRead(path, reason(error));
    return bytes;
  } catch (const std::bad_alloc&) {
    failWithoutMemory(what);
  }
}

void writeFile(const fs::path& path, std::span<const std::byte> bytes) {
  if (path == "-") {
    if (const int error = writeAll(STDOUT_FILENO, bytes)) {
      badUsage("can't write to standard output: {}; write to a file instead", reason(error));
    }
    return;
  }
  if (path.empty()) badUsage("can't write to a file without a name; give the name of a file");
  if (const int error = writeWhole(path, bytes)) failToWrite(path, error);
}

std::optional<fs::path> cacheFolder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string_view(value ? value : "");
  };
  const std::string_view off = variable("LATELIGHT_NO_CACHE");
  if (!off.empty() && off != "0") return std::nullopt;
  // XDG Base Directory Specification: relative paths are invalid and ignored; new folders are private.
  fs::path base = variable("XDG_CACHE_HOME");
  if (!base.is_absolute()) {
    const fs::path home = variable("HOME");
    if (!home.is_absolute()) return std::nullopt;
    base = home / ".cache";
  }
  const fs::path folder = base / "latelight";
  std::error_code error;
  fs::create_directories(base, error);
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return std::nullopt;
  if (!fs::is_directory(folder, error)) return std::nullopt;
  return folder;
}

// An entry ends in the XXH3 of what is before it: drivers trust the pipeline caches they are given, and a machine that
// lost power may show a file whose name arrived and whose contents did not.
std::optional<std::vector<std::byte>> loadCache(std::string_view name) {
  assert(name.find('/') == std::string_view::npos);
  const std::optional<fs::path> folder = cacheFolder();
  std::error_code error;
  if (!folder || !fs::is_regular_file(*folder / name, error)) return std::nullopt;
  try {
    std::vector<std::byte> bytes = readFile(*folder / name);
    uint64_t sum = 0;
    if (bytes.size() < sizeof(sum)) return std::nullopt;
    const size_t size = bytes.size() - sizeof(sum);
    std::memcpy(&sum, bytes.data() + size, sizeof(sum));
    if (sum != hash64(bytes.data(), size)) return std::nullopt;
    bytes.resize(size);
    return bytes;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void storeCache(std::string_view name, std::span<const std::byte> bytes) try {
  assert(name.find('/') == std::string_view::npos);
  const std::optional<fs::path> folder = cacheFolder();
  if (!folder) return;
  const uint64_t sum = hash64(bytes.data(), bytes.size());
  std::vector<std::byte> entry(bytes.size() + sizeof(sum));
  if (!bytes.empty()) std::memcpy(entry.data(), bytes.data(), bytes.size());
  std::memcpy(entry.data() + bytes.size(), &sum, sizeof(sum));
  writeWhole(*folder / name, entry);  // a full disk: no entry, no harm
} catch (const std::exception&) {
  // A cache is never required: not even its memory.
}

}  // namespace latelight
