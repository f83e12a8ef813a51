// The lists of `latelight list`, for other code that shows them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace latelight::app {

struct ListedName {
  std::string name, description;
};

// "layouts", "aovs", ...
std::vector<std::string> listTopics();
// Returns the names in a list, in its order, or nothing if there is no such list.
std::vector<ListedName> listedNames(std::string_view topic);

}  // namespace latelight::app
