// The lists of `latelight list`, for what else shows them.
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
// What such a list names, in its order; nothing where there is no such list.
std::vector<ListedName> listedNames(std::string_view topic);

}  // namespace latelight::app
