// Stops a batch on SIGTERM or SIGINT after the frames in flight are written.
#pragma once

namespace latelight::data {

// Installs the handlers. The first signal requests a stop. The second restores the previous action of that signal and
// raises it again, which normally ends the process.
void stopOnSignals();

// Returns the signal that requested the stop, or 0 if there was none.
int stopSignal();

// Thrown to abandon long work because of a signal. It does not derive from std::exception, because nothing has failed
// and handlers of failures must not catch it.
struct Stopped {
  int signal;
};

// Throws Stopped if a signal has requested a stop. For loops that may run long between frames.
void throwIfStopped();

}  // namespace latelight::data
