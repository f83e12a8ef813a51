// A log of events in long-running programs, as lines on standard error.
#pragma once

#include <string>

namespace latelight {

// Prints "12:34:56 sentence" with the time of day in UTC; prints nothing with --quiet. Thread-safe.
void record(const std::string& sentence);

}  // namespace latelight
