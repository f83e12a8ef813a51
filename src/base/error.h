// Errors end the program with one sentence and an exit code: throw for run-time errors, assert for logic errors.
#pragma once

#include <fmt/format.h>
#include <latelight/latelight.h>

#include <string>

namespace latelight {

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
