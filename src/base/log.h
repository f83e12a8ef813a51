// Warnings, each printed once, and progress bars on standard error.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// Text that is safe to print. Names from a scene file are part of messages: they must not contain terminal control
// sequences or line breaks, nor change the direction of the text around them. Such characters (C0 and C1 controls, line
// and paragraph separators, bidirectional controls) and bytes that are not UTF-8 become "?".
std::string printable(std::string_view text);

// Prints "warning: <sentence>" on standard error, each sentence only once per process, or calls the function of
// setWarningHandler() in the public header. Thread-safe.
void warn(const std::string& sentence);
template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  warn(fmt::format(format, std::forward<Args>(args)...));
}

// During its lifetime, warnings of its thread are appended to `captured` instead of being printed. Jobs that run in
// parallel use it to print their warnings in the same order on each run.
class WarningCapture {
 public:
  explicit WarningCapture(std::vector<std::string>& captured);
  ~WarningCapture();
  WarningCapture(const WarningCapture&) = delete;
  WarningCapture& operator=(const WarningCapture&) = delete;

 private:
  std::vector<std::string>* const previous_;
};

// Implements --quiet: no warnings, no progress bars, no journal.
void setQuiet(bool quiet);

// Displays progress bars, or not, which is the default: only the program draws on the terminal, not the library.
void showProgress(bool shown);

// A progress bar on standard error during its lifetime. It prints nothing unless bars are shown and standard error is
// a terminal, nor for the first `silence` seconds, because short work needs no bar. step() may be called from any
// thread.
class Progress {
 public:
  Progress(std::string_view what, uint64_t total, double silence = 0.3);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void step(uint64_t count = 1);

 private:
  struct State;
  State* state_;
};

}  // namespace latelight
