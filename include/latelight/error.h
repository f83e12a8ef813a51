// The exception that every function of Latelight's public C++ API may throw. latelight.h includes this file.
#pragma once

#include <stdexcept>
#include <string>

#define LATELIGHT_API __attribute__((visibility("default")))

namespace latelight {

// The program's exit codes.
enum class ExitCode {
  Done = 0,
  Internal = 1,
  Usage = 2,       // an invalid argument
  BadInput = 3,    // a file that is missing, broken or needs unsupported features
  NoDevice = 4,    // no Vulkan 1.3 device
  DeviceLost = 5,  // the driver stopped the device; a new one may work
  SomeFramesFailed = 6,
  OutOfMemory = 7,  // of the device or the machine, or a limit of the device; use a smaller image or scene
};

// The message is one sentence that says what is wrong, where, and what to do.
class LATELIGHT_API Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence);
  ~Error() override;
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace latelight
