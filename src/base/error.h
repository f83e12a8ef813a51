// Functions that throw latelight::Error, which ends the program with one sentence and an exit code. Run-time errors
// throw; logic errors assert.
#pragma once

#include <fmt/format.h>
#include <latelight/error.h>

#include <string>
#include <string_view>
#include <type_traits>

namespace latelight {

// User or file text as quoted in a message: the full text, or only its beginning and end if it is too long to read.
std::string shortened(std::string_view text);

// shortened() for texts; returns other values unchanged.
template <typename T>
decltype(auto) shortenedIfText(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return shortened(value);
  else
    return (value);
}

// Takes its arguments as lvalues, which fmt::make_format_args() requires.
template <typename... Args>
std::string formatted(fmt::string_view format, const Args&... args) {
  return fmt::vformat(format, fmt::make_format_args(args...));
}

template <typename... Args>
[[noreturn]] void fail(ExitCode code, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(code, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
[[noreturn]] void badInput(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ExitCode::BadInput, formatted(format, shortenedIfText(args)...));
}
template <typename... Args>
[[noreturn]] void badUsage(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ExitCode::Usage, formatted(format, shortenedIfText(args)...));
}

}  // namespace latelight
