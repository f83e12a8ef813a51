// A file being written under a temporary name, removed however the program ends, short of SIGKILL.
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace latelight {

// A new file next to the one it will replace, named ".NAME.PID-SERIAL.latelight-tmp" and locked (flock) while it lives.
// The lock ends with the process: it distinguishes files left by killed processes from those still being written, also
// by other containers and machines. The first file in a folder sweeps those left there.
class TemporaryFile {
 public:
  // `permissions` as in open(), subject to the umask.
  TemporaryFile(const std::filesystem::path& target, mode_t permissions);
  ~TemporaryFile();  // removes it, unless it was renamed
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  int get() const { return fd_; }                   // to write to
  int error() const { return error_; }              // 0, or the errno of the failed creation
  int become(const std::filesystem::path& target);  // 0 or an errno: renames it, once it is completely written

 private:
  friend void removeTemporaryFiles();
  int makeOnce(mode_t permissions);
  void leaveList();
  void discard();

  std::filesystem::path path_;
  int fd_ = -1, error_ = 0;
  bool listed_ = false;
  TemporaryFile *previous_ = nullptr, *next_ = nullptr;  // in the list of all
};

// Removes all temporary files of the process, in a signal handler that ends it: no file can be created afterwards.
// (fatal_signals.h)
void removeTemporaryFiles();

}  // namespace latelight
