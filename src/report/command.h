// Command lines that can be pasted into a shell.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace latelight::report {

// Returns `latelight` and these words, with quotes if a shell would otherwise change them.
std::string commandLine(std::span<const std::string> words);

// Returns the same command as HTML.
std::string commandHtml(std::span<const std::string> words);

// Returns the concatenation of two lists.
std::vector<std::string> joined(std::vector<std::string> words, std::span<const std::string> more);

}  // namespace latelight::report
