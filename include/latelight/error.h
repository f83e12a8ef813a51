// The exception that every function of Latelight's public C++ API may throw. latelight.h includes it.
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
  DeviceLost = 5,  // or out of memory, on the device or the machine
  SomeFramesFailed = 6,
};

// One sentence: what, where, what to do.
class LATELIGHT_API Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence);
  ~Error() override;
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace latelight
