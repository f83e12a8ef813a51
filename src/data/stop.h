// SIGTERM and SIGINT end a batch once the frames in flight are written.
#pragma once

namespace latelight::data {

// From here on the first of these signals asks for the end, and the second one ends the process as it would have.
void stopOnSignals();

// The signal that asked for the end; 0: none did.
int stopSignal();

// Thrown where work that may take long is given up because of a signal. It is no std::exception: nothing has failed,
// and no handler of failures may take it for one.
struct Stopped {
  int signal;
};

// For loops that may run long between frames.
void throwIfStopped();

}  // namespace latelight::data
