// `latelight render` in process, on one shared device, because a separate process for each picture requires too much
// time.
#pragma once

#include <string>
#include <vector>

namespace latelight::view {

// Returns the file that the command writes with -o `file`; `words` begin with "latelight". Errors fail the test.
std::string rendered(const std::vector<std::string>& words, const std::string& file);

}  // namespace latelight::view
