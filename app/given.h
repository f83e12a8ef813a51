// The command line as it was given, to be repeated.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::app {

// The options that were given to a command, in the order of its help, but for those of these long names.
std::vector<std::string> givenOptions(const CLI::App& command, const std::vector<std::string_view>& but);

}  // namespace latelight::app
