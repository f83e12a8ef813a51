// Handlers for signals that end the program: they remove its temporary files, and print a backtrace after a crash.
#pragma once

#include <cstddef>
#include <memory>

namespace latelight {

// Installs the handlers. Every signal that would end the process then first removes its temporary files. A signal that
// reports a crash, such as SIGSEGV, then prints a backtrace to standard error. The process ends by the same signal.
// Signals that are ignored or already have handlers are unchanged. Programs call this function from the main thread;
// libraries do not.
void handleFatalSignals();

// An alternate stack for this thread's signal handlers, so that they run even if the thread's own stack has overflowed.
// It exists for the lifetime of this object, in programs that called handleFatalSignals(), and only for threads without
// one. handleFatalSignals() creates one for the main thread.
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
