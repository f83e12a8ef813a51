// A file that is being written under a name of its own, and goes whatever ends the program short of SIGKILL.
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace latelight {

// A new file beside the one that it will be, named ".NAME.PID-SERIAL.latelight-tmp" and locked (flock) while it lives.
// The lock goes with the process: by it, what a killed process left is told from what others write now, in other
// containers and on other machines too. The first file in a folder sweeps what such processes left there.
class TemporaryFile {
 public:
  // `permissions` as open's: what the file mode creation mask takes away is missing.
  TemporaryFile(const std::filesystem::path& target, mode_t permissions);
  ~TemporaryFile();  // removes it, unless it was renamed
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  int get() const { return fd_; }                   // to write to
  int error() const { return error_; }              // 0, or the errno of what kept it from being made
  int become(const std::filesystem::path& target);  // 0 or an errno: renames it, once all of it is written

 private:
  friend void removeTemporaryFiles(int signal);
  int makeOnce(mode_t permissions);
  void leaveList();
  void discard();

  std::filesystem::path path_;
  int fd_ = -1, error_ = 0;
  bool listed_ = false;
  TemporaryFile *previous_ = nullptr, *next_ = nullptr;  // in the list of all
};

// From here on every signal that would end the process first removes its temporary files; it then ends by that very
// signal. Signals that are ignored, or have handlers already, are left alone. For programs: a library has no say in it.
void removeTemporaryFilesOnSignals();

}  // namespace latelight
