#include "base/allowed_folders.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/files.h"

namespace latelight {
namespace fs = std::filesystem;
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

// Opens a path that contains no links, one component at a time and without following links, so that no component can be
// replaced by a link after the check. It opens only folders and regular files, because opening a device may have side
// effects.
Descriptor openWithoutLinks(const fs::path& real) {
  Descriptor at(open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
  const fs::path steps = real.relative_path();
  for (auto step = steps.begin(); at && step != steps.end(); ++step) {
    struct stat status {};
    if (fstatat(at.get(), step->c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return Descriptor(-1);
    const bool last = std::next(step) == steps.end();
    if (last && !S_ISREG(status.st_mode)) return Descriptor(-1);
    const int flags = last ? O_RDONLY | O_NONBLOCK | O_NOCTTY : O_PATH | O_DIRECTORY;
    at = Descriptor(openat(at.get(), step->c_str(), flags | O_NOFOLLOW | O_CLOEXEC));
  }
  return at;
}

// File systems whose regular files contain information from the kernel about processes and devices.
bool isOfKernel(int fd) {
  constexpr long kKernels[] = {PROC_SUPER_MAGIC, SYSFS_MAGIC,        DEBUGFS_MAGIC,      TRACEFS_MAGIC,
                               SECURITYFS_MAGIC, CGROUP_SUPER_MAGIC, CGROUP2_SUPER_MAGIC};
  struct statfs status {};
  return fstatfs(fd, &status) != 0 ||
         std::find(std::begin(kKernels), std::end(kKernels), static_cast<long>(status.f_type)) != std::end(kKernels);
}

bool isRegular(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
}

}  // namespace

AllowedFolders::AllowedFolders(const fs::path& owner, std::span<const std::string> allowed, FileObserver observer)
    : observer_(std::move(observer)) {
  std::error_code ignored;
  for (const fs::path& file : {fs::absolute(owner, ignored), fs::canonical(owner, ignored)}) {
    const fs::path folder = fs::canonical(file.parent_path(), ignored);
    if (!folder.empty() && (own_.empty() || own_.front() != folder)) own_.push_back(folder);
  }
  for (const std::string& name : allowed) {
    const fs::path folder = fs::canonical(name, ignored);
    if (!fs::is_directory(folder, ignored))
      badUsage("'{}' is not a folder: --allow-outside requires a folder from which the scene may read", name);
    allowed_.push_back(folder);
  }
}

bool AllowedFolders::holds(const fs::path& real) const {
  const auto isAbove = [&](const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end();
  };
  return std::any_of(own_.begin(), own_.end(), isAbove) || std::any_of(allowed_.begin(), allowed_.end(), isAbove);
}

void AllowedFolders::observe(const fs::path& file) const {
  if (observer_) observer_(file);
}

bool AllowedFolders::exists(const fs::path& name) const {
  if (own_.empty()) return false;
  const fs::path file = own_.front() / name;
  observe(file);
  std::error_code ignored;
  return fs::exists(file, ignored);
}

std::vector<std::byte> AllowedFolders::read(const fs::path& name) const {
  fs::path real;
  std::error_code error = std::make_error_code(std::errc::no_such_file_or_directory);
  for (auto folder = own_.begin(); real.empty() && folder != own_.end(); ++folder) {
    observe(*folder / name);
    real = fs::canonical(*folder / name, error);
  }
  if (error == std::errc::no_such_file_or_directory) badInput("is the file {}, which does not exist", name.string());
  if (error) badInput("is the file {}, which cannot be found: {}", name.string(), error.message());
  if (!holds(real))
    badInput(
        "is the file {}, which is outside the scene's folder, at {}: move it there, or allow its folder with "
        "--allow-outside",
        name.string(), real.string());
  const Descriptor file = openWithoutLinks(real);
  const int reason = errno;
  if (!file && fs::is_regular_file(real, error))
    badInput("is the file {}, which cannot be read: {}", name.string(), std::generic_category().message(reason));
  if (!file || !isRegular(file.get()) || isOfKernel(file.get()))
    badInput("is {}, which is not a regular file: a scene must not read devices, pipes, folders or kernel files",
             name.string());
  return readFile(file.get(), real);
}

}  // namespace latelight
