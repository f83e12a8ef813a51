#include "base/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_set>

#include "base/fork.h"

namespace latelight {
namespace fs = std::filesystem;

struct TemporaryFileList {
  TemporaryFile* first = nullptr;
  std::atomic_flag taken;
};

namespace {

constexpr std::string_view kEnding = ".latelight-tmp";
constexpr size_t kMaxOfName = 200;  // bytes of the target's name; most file systems allow 255 in total

// --- lists of all temporary files, which signal handlers read -------------------------------------------------------

// A thread uses one of the lists, so that threads that write files rarely wait for each other.
TemporaryFileList lists[64];

TemporaryFileList& listOfThread() {
  static std::atomic<size_t> threads = 0;
  thread_local const size_t thread = threads++;
  return lists[thread % std::size(lists)];
}

// Waits by sleeping, because signal handlers may not use any better method.
void take(TemporaryFileList& list) {
  constexpr timespec kMillisecond{0, 1'000'000};
  while (list.taken.test_and_set(std::memory_order_acquire)) nanosleep(&kMillisecond, nullptr);
}

// Locks a list with signals blocked, so a handler that waits for the lock always waits for another thread.
class ListLock {
 public:
  explicit ListLock(TemporaryFileList& list) : list_(list) {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
    take(list_);
  }
  ~ListLock() {
    list_.taken.clear(std::memory_order_release);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  ListLock(const ListLock&) = delete;
  ListLock& operator=(const ListLock&) = delete;

 private:
  TemporaryFileList& list_;
  sigset_t before_;
};

// --- files left by killed processes ---------------------------------------------------------------------------------

// ".NAME.PID-SERIAL.latelight-tmp".
bool isTemporaryName(std::string_view name) {
  if (!name.starts_with('.') || !name.ends_with(kEnding)) return false;
  name.remove_suffix(kEnding.size());
  const size_t dot = name.rfind('.');
  const size_t dash = std::min(name.find('-', dot), name.size());
  const auto isNumber = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  };
  return dot > 0 && isNumber(name.substr(dot + 1, dash - dot - 1)) && dash < name.size() &&
         isNumber(name.substr(dash + 1));
}

void removeUnlessLocked(const fs::path& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  struct stat status {};
  if (fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && flock(fd, LOCK_EX | LOCK_NB) == 0) unlink(path.c_str());
  close(fd);
}

// Removes the files of killed processes, once per process and folder.
void sweep(const fs::path& folder) {
  static ForkSafeMutex mutex;
  static std::unordered_set<std::string> swept;
  {
    std::lock_guard lock(mutex);
    if (!swept.insert(folder.string()).second) return;
  }
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (isTemporaryName(entry->path().filename().string())) removeUnlessLocked(entry->path());
}

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& target, mode_t permissions) {
  static std::atomic<unsigned> serial = 0;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
  const std::string name = target.filename().string().substr(0, kMaxOfName);
  sweep(folder);
  do {
    path_ = folder / fmt::format(".{}.{}-{}{}", name, getpid(), serial++, kEnding);
    error_ = makeOnce(permissions);
  } while (error_ == EEXIST);
}

// Returns EEXIST if the name is taken, or if a sweep of another process removed the file before it was locked.
int TemporaryFile::makeOnce(mode_t permissions) {
  {
    TemporaryFileList& list = listOfThread();
    const ListLock lock(list);  // created and listed atomically: a handler sees it either listed or not existing
    fd_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, permissions);
    if (fd_ < 0) return errno;
    next_ = list.first;
    if (next_) next_->previous_ = this;
    list.first = this;
    list_ = &list;
  }
  // On file systems without locks, no file is swept either.
  const bool swept = flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  struct stat status {};
  if (!swept && (fstat(fd_, &status) != 0 || status.st_nlink > 0)) return 0;
  discard();
  return EEXIST;
}

// Network file systems may report a full disk only when a descriptor is closed. This closes a duplicate, because the
// lock must last until the file is renamed.
int TemporaryFile::checkWritten() const {
  const int copy = fcntl(fd_, F_DUPFD_CLOEXEC, 0);
  return copy < 0 || close(copy) != 0 ? errno : 0;
}

int TemporaryFile::become(const fs::path& target) {
  if (const int error = checkWritten()) return error;
  const ListLock lock(*list_);
  if (rename(path_.c_str(), target.c_str()) != 0) return errno;
  removeFromList();  // immediately, because its old name may soon be reused
  return 0;
}

void TemporaryFile::removeFromList() {
  (previous_ ? previous_->next_ : list_->first) = next_;
  if (next_) next_->previous_ = previous_;
  previous_ = next_ = nullptr;
  list_ = nullptr;
}

void TemporaryFile::discard() {
  if (fd_ < 0) return;
  if (list_) {
    const ListLock lock(*list_);
    unlink(path_.c_str());
    removeFromList();
  }
  close(fd_);
  fd_ = -1;
}

TemporaryFile::~TemporaryFile() {
  discard();
}

void removeTemporaryFiles() {
  for (TemporaryFileList& list : lists) {
    take(list);  // never released, so no thread creates another file or removes one from the list
    for (TemporaryFile* file = list.first; file; file = file->next_) unlink(file->path_.c_str());
  }
}

}  // namespace latelight
