// What happens in a program that runs on, as lines on standard error.
#pragma once

#include <string>

namespace latelight {

// "12:34:56 sentence", of the day in UTC; nothing with --quiet. Thread-safe.
void record(const std::string& sentence);

}  // namespace latelight
