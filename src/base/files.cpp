#include "base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
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
#include "base/parallel.h"
#include "base/temporary_file.h"
#include "base/text.h"
#include "base/write.h"

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
  // Returns 0 or an errno. Network file systems may report a full disk only here.
  int close() {
    const int result = fd_ >= 0 ? ::close(fd_) : 0;
    fd_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

// Returns 0 or an errno. `size` is the size that the file reports; pipes and files in /proc report 0.
int readAll(int fd, size_t size, std::vector<std::byte>& bytes) {
  constexpr size_t kChunk = size_t{1} << 16;
  bytes.resize(size);
  for (size_t filled = 0;;) {
    if (filled == bytes.size() && filled > size) bytes.resize(filled * 2);
    std::byte probe;  // at the reported size: usually the end of the file, detected without growing the vector
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

// The target of a write, and what exists there.
struct WriteTarget {
  fs::path path;    // with links resolved
  mode_t mode = 0;  // st_mode; 0: nothing exists there
  uid_t user = 0;   // owner of the existing file
  gid_t group = 0;
  bool isFile() const { return mode == 0 || S_ISREG(mode); }
};

// Throws Error(Usage) for targets that must not be written to, even if permissions allow it.
WriteTarget findTarget(const fs::path& path) {
  if (path.empty()) badUsage("can't write to a file without a name; give a file name");
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    if (errno != ENOENT) failToWrite(path, errno);
    return {.path = path};
  }
  if (S_ISLNK(status.st_mode) && stat(path.c_str(), &status) != 0) {
    if (errno != ENOENT) failToWrite(path, errno);
    std::error_code ignored;
    badUsage("can't write '{}': it is a link to '{}', which does not exist; remove the link, or create that file first",
             path.string(), fs::read_symlink(path, ignored).string());
  }
  if (S_ISDIR(status.st_mode)) badUsage("can't write '{}': it is a folder; give a file name", path.string());
  if (S_ISBLK(status.st_mode) || S_ISSOCK(status.st_mode))
    badUsage("can't write '{}': it is a {}; give a file name", path.string(),
             S_ISBLK(status.st_mode) ? "disk" : "socket");
  if (access(path.c_str(), W_OK) != 0 && errno == EROFS)
    badUsage("can't write '{}': the file system is read-only; mount it for writing, or choose another place",
             path.string());
  const bool isRejected = S_ISREG(status.st_mode) && access(path.c_str(), W_OK) != 0;
  if (isRejected && status.st_uid != geteuid())
    badUsage(
        "can't write '{}': the existing file belongs to another user, who does not allow writing to it; choose "
        "another name",
        path.string());
  // Also checks the mode bits, because root may write to any file.
  if (S_ISREG(status.st_mode) && ((status.st_mode & 0222) == 0 || isRejected))
    badUsage("can't write '{}': the existing file is read-only; allow writing (chmod u+w), or choose another name",
             path.string());
  // Resolves links, so that the file is replaced and the links remain.
  std::error_code error;
  const fs::path target = fs::canonical(path, error);
  return {error ? path : target, status.st_mode, status.st_uid, status.st_gid};
}

// Returns 0 or an errno. Copies the attributes of the replaced file to the new file, as far as this user is permitted;
// set-user-ID and similar bits are dropped.
int copyAttributes(int fd, const WriteTarget& target) {
  constexpr auto kSameUser = static_cast<uid_t>(-1);
  constexpr auto kSameGroup = static_cast<gid_t>(-1);
  struct stat made {};
  if (fstat(fd, &made) != 0) return errno;
  [[maybe_unused]] const bool user = made.st_uid == target.user || fchown(fd, target.user, kSameGroup) == 0;
  const bool group = made.st_gid == target.group || fchown(fd, kSameUser, target.group) == 0;
  // The old group's permissions must not apply to another group.
  return fchmod(fd, target.mode & (group ? 0777 : 0707)) == 0 ? 0 : errno;
}

// Permissions of a temporary file before it receives the attributes of the file that it replaces.
mode_t firstPermissions(const WriteTarget& target) {
  return target.mode ? target.mode & 0600 : 0666;
}

// Returns 0 or an errno.
int writeTemporary(TemporaryFile& file, const WriteTarget& target, std::span<const std::byte> bytes) {
  if (file.error()) return file.error();
  if (target.mode)
    if (const int error = copyAttributes(file.get(), target)) return error;
  return writeAll(file.get(), bytes);
}

// 0 or an errno.
int replace(const WriteTarget& target, std::span<const std::byte> bytes) {
  TemporaryFile file(target.path, firstPermissions(target));
  if (const int error = writeTemporary(file, target, bytes)) return error;
  return file.become(target.path);
}

// Returns 0 or an errno. Writes directly to a pipe or a device, which cannot be replaced by renaming.
int writeInto(const fs::path& path, std::span<const std::byte> bytes) {
  // O_NONBLOCK: opening a pipe without a reader must not block; it fails with ENXIO instead.
  File file(path, O_WRONLY | O_NONBLOCK | O_NOCTTY);
  if (!file) return errno;
  fcntl(file.get(), F_SETFL, 0);
  const int error = writeAll(file.get(), bytes);
  const int closing = file.close();
  return error ? error : closing;
}

}  // namespace

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::vector<std::byte> readFile(const fs::path& path) {
  // O_NONBLOCK: opening a pipe without a writer must not block; the flag has no effect on regular files.
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
  // Checks the limit first: with overcommitted memory, the allocation would succeed and the process would be killed
  // later.
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

namespace {

// Reads the bytes [begin, end) of a file. Returns false for an error or if the file is shorter.
bool readRange(int fd, size_t begin, size_t end, std::byte* to) {
  while (begin < end) {
    const ssize_t got = pread(fd, to, end - begin, static_cast<off_t>(begin));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    begin += static_cast<size_t>(got);
    to += got;
  }
  return true;
}

}  // namespace

FileBytes readLargeFile(const fs::path& path) {
  constexpr size_t kPiece = size_t{4} << 20;
  File file(path, O_RDONLY | O_NONBLOCK);
  if (!file) failToRead(path, reason(errno));
  struct stat status {};
  if (fstat(file.get(), &status) != 0) failToRead(path, reason(errno));
  if (S_ISREG(status.st_mode) && status.st_size > 0) {
    const auto size = static_cast<size_t>(status.st_size);
    const std::string what = fmt::format("the file '{}'", path.string());
    const MemoryClaim claim(size, what);
    std::unique_ptr<std::byte[]> bytes(new (std::nothrow) std::byte[size]);
    if (!bytes) failWithoutMemory(what);
    std::atomic<bool> complete = true;
    parallelFor((size + kPiece - 1) / kPiece, 1, [&](size_t begin, size_t end) {
      const size_t first = begin * kPiece;
      if (!readRange(file.get(), first, std::min(end * kPiece, size), bytes.get() + first)) complete = false;
    });
    std::byte more;
    if (complete && pread(file.get(), &more, 1, status.st_size) == 0) return {std::move(bytes), size};
  }
  // Pipes, files that change meanwhile, files in /proc, which report no size, and errors.
  const std::vector<std::byte> all = readFile(file.get(), path);
  std::unique_ptr<std::byte[]> bytes(new std::byte[all.size()]);
  std::ranges::copy(all, bytes.get());
  return {std::move(bytes), all.size()};
}

std::string shortFileName(std::string name) {
  constexpr size_t kHashed = 17;  // bytes of "-" and the hash
  if (name.size() <= kShortFileName) return name;
  const uint64_t hash = hash64(name.data(), name.size());
  return fmt::format("{}-{:016x}", utf8Beginning(name, kShortFileName - kHashed), hash);
}

void writeFile(const fs::path& path, std::span<const std::byte> bytes) {
  if (path == "-") {
    if (const int error = writeAll(STDOUT_FILENO, bytes)) {
      badUsage("can't write to standard output: {}; write to a file instead", reason(error));
    }
    return;
  }
  const WriteTarget target = findTarget(path);
  const int error = target.isFile() ? replace(target, bytes) : writeInto(path, bytes);
  if (error == ENXIO && S_ISFIFO(target.mode))
    badUsage("can't write '{}': it is a pipe without a reader; start the reader first", path.string());
  if (error) failToWrite(path, error);
}

struct FileGroup::Pending {
  explicit Pending(const fs::path& path)
      : path(path), target(findTarget(path)), file(target.path, firstPermissions(target)) {}

  const fs::path path;
  const WriteTarget target;
  TemporaryFile file;
};

FileGroup::FileGroup() = default;
FileGroup::~FileGroup() = default;

void FileGroup::add(const fs::path& path, std::span<const std::byte> bytes) {
  if (path == "-" || !findTarget(path).isFile()) return writeFile(path, bytes);
  if (pending_.size() == kMaxPending) renameFirst();
  auto pending = std::make_unique<Pending>(path);
  int error = writeTemporary(pending->file, pending->target, bytes);
  if (!error) error = pending->file.checkWritten();
  if (error) failToWrite(path, error);
  pending_.push_back(std::move(pending));
}

void FileGroup::renameFirst() {
  Pending& first = *pending_.front();
  if (const int error = first.file.become(first.target.path)) failToWrite(first.path, error);
  pending_.pop_front();
}

void FileGroup::commit() {
  while (!pending_.empty()) renameFirst();
}

void checkWritable(const fs::path& path) {
  if (path == "-") return;
  const WriteTarget target = findTarget(path);
  if (!target.isFile()) return;
  if (const int error = TemporaryFile(target.path, 0600).error()) failToWrite(path, error);
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

// An entry ends with the XXH3 hash of all preceding bytes. Drivers trust the pipeline caches that they load, and after
// a power loss a file may exist without its contents.
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
  // Replaces any existing entry, even a pipe or a link. On a full disk, no entry is stored.
  replace({.path = *folder / name}, entry);
} catch (const std::exception&) {
  // A cache is never required, so running out of memory for it is not an error.
}

}  // namespace latelight
