// Command lines as people paste them into a shell.
#pragma once

#include <span>
#include <string>

namespace latelight::view {

// The words, quoted where a POSIX shell would see something else in them.
std::string shellWords(std::span<const std::string> words);

}  // namespace latelight::view
