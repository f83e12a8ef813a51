// `latelight render` in process, on one device for all: a program of its own for each picture takes too long.
#pragma once

#include <string>
#include <vector>

namespace latelight::view {

// The file that these words, from "latelight" on, write with -o `file`. Errors are failures of the test.
std::string rendered(const std::vector<std::string>& words, const std::string& file);

}  // namespace latelight::view
