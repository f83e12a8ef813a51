// Command lines that work when they are pasted into a shell.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace latelight::report {

// `latelight` and these words, quoted where a shell would not take them as they are.
std::string commandLine(std::span<const std::string> words);

// The same in HTML, for what stands before it.
std::string commandHtml(std::span<const std::string> words);

// Two lists, one after the other.
std::vector<std::string> joined(std::vector<std::string> words, std::span<const std::string> more);

}  // namespace latelight::report
