// The options of a command line, for repeating it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::app {

// Returns the options that were passed to a command, in the order of its help, except those with these long names.
std::vector<std::string> explicitOptions(const CLI::App& command, const std::vector<std::string_view>& but);

}  // namespace latelight::app
