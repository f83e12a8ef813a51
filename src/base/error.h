// Errors end the program with one sentence and an exit code: throw for run-time errors, assert for logic errors.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace latelight {

enum class ExitCode {
  Done = 0,
  Internal = 1,
  Usage = 2,
  BadInput = 3,
  NoDevice = 4,
  DeviceLost = 5,  // or out of its memory
  SomeFramesFailed = 6,
};

// One sentence for the user: what, where, what to do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

template <typename... Args>
[[noreturn]] void fail(ExitCode code, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(code, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
[[noreturn]] void badInput(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ExitCode::BadInput, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
[[noreturn]] void badUsage(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ExitCode::Usage, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace latelight
