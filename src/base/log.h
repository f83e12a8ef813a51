// Output on standard error besides errors: warnings, each once, and progress.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// Names from a scene file are part of sentences: they must not contain terminal control sequences or line breaks, nor
// change the direction of the text around them. Such characters (C0 and C1 controls, line and paragraph separators,
// bidirectional controls), and bytes that are not UTF-8, become "?".
std::string printable(std::string_view text);

// Prints "warning: <sentence>" on standard error; the same sentence only once per process. Thread-safe.
void warn(const std::string& sentence);
template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  warn(fmt::format(format, std::forward<Args>(args)...));
}

// While it lives, warnings of its thread are kept instead of printed. Jobs that run in parallel use it so that their
// warnings can be printed in the same order in each run.
class WarningCapture {
 public:
  explicit WarningCapture(std::vector<std::string>& captured);
  ~WarningCapture();
  WarningCapture(const WarningCapture&) = delete;
  WarningCapture& operator=(const WarningCapture&) = delete;

 private:
  std::vector<std::string>* const previous_;
};

// --quiet: no warnings, no progress.
void setQuiet(bool quiet);

// A progress bar on standard error while it lives; silent unless standard error is a terminal, and for the first
// `silence` seconds: short work needs no bar.
// step() may be called from any thread.
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
