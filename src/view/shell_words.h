// Formats command lines for pasting into a shell.
#pragma once

#include <span>
#include <string>

namespace latelight::view {

// Returns the words joined by spaces, quoted as a POSIX shell requires.
std::string shellWords(std::span<const std::string> words);

}  // namespace latelight::view
