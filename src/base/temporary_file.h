// Files that are written under a temporary name and removed however the program ends, except by SIGKILL.
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace latelight {

struct TemporaryFileList;

// A new file next to the one that it will replace, named ".NAME.PID-SERIAL.latelight-tmp" and locked (flock) for its
// lifetime. The lock ends with the process: it distinguishes files of killed processes from those still being written,
// also by other containers and machines. The first file in a folder removes the files of killed processes there.
class TemporaryFile {
 public:
  // Creates the file. `permissions` are those of open(), subject to the umask.
  TemporaryFile(const std::filesystem::path& target, mode_t permissions);
  ~TemporaryFile();  // removes the file, unless it was renamed
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  int get() const { return fd_; }                   // file descriptor to write to
  int error() const { return error_; }              // 0, or the errno of the failed creation
  int checkWritten() const;                         // returns 0, or the errno of an error that closing a file reports
  int become(const std::filesystem::path& target);  // renames the completely written file; returns 0 or an errno

 private:
  friend void removeTemporaryFiles();
  int makeOnce(mode_t permissions);
  void removeFromList();
  void discard();

  std::filesystem::path path_;
  int fd_ = -1, error_ = 0;
  TemporaryFileList* list_ = nullptr;                    // that contains this file; null if none
  TemporaryFile *previous_ = nullptr, *next_ = nullptr;  // links of that list
};

// Removes all temporary files of the process, in a signal handler that ends it (fatal_signals.h). No file can be
// created afterward.
void removeTemporaryFiles();

}  // namespace latelight
