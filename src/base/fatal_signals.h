// Signals that end the program: its temporary files are removed first, and where it crashed, it prints a backtrace.
#pragma once

#include <cstddef>
#include <memory>

namespace latelight {

// From here on every signal that would end the process first removes its temporary files; one that reports a crash, as
// SIGSEGV does, then prints where it happened to standard error. The process then ends by the same signal. Signals that
// are ignored or already have handlers are left alone. Programs call this from the main thread; libraries do not.
void handleFatalSignals();

// A stack for this thread's signal handlers, so that they run where the thread's own stack has overflowed: for the
// lifetime of this object, in programs that called handleFatalSignals(), in threads that have none yet. The main thread
// gets one there.
class SignalStack {
 public:
  SignalStack();
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<std::byte[]> memory_;
};

}  // namespace latelight
