// What every function of Latelight's public C++ API may throw. latelight.h includes it.
#pragma once

#include <stdexcept>
#include <string>

#define LATELIGHT_API __attribute__((visibility("default")))

namespace latelight {

// The program ends with these.
enum class ExitCode {
  Done = 0,
  Internal = 1,
  Usage = 2,       // an argument that can't be
  BadInput = 3,    // a file that is missing, broken or needs what is not supported
  NoDevice = 4,    // no Vulkan 1.3 device
  DeviceLost = 5,  // or out of memory, its or the machine's
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
