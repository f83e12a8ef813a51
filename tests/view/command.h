// `latelight render` in process, on one shared device, because a separate process for each picture requires too much
// time.
#pragma once

#include <string>
#include <vector>

namespace latelight::view {

// The file that these words, from "latelight" on, write with -o `file`. Errors are failures of the test.
std::string rendered(const std::vector<std::string>& words, const std::string& file);

}  // namespace latelight::view
