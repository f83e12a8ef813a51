// SIGTERM and SIGINT end a batch once the frames in flight are written.
#pragma once

namespace latelight::data {

// From here on the first of these signals asks for the end, and the second one ends the process as it would have.
void stopOnSignals();

// The signal that asked for the end; 0: none did.
int stopSignal();

}  // namespace latelight::data
