#include "app/explicit_options.h"

#include <algorithm>

namespace latelight::app {

std::vector<std::string> explicitOptions(const CLI::App& command, const std::vector<std::string_view>& but) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (std::ranges::find(but, name) != but.end()) continue;
    if (option->get_items_expected_max() == 0) {
      words.push_back("--" + name);
      continue;
    }
    for (const std::string& value : option->results())
      if (value.starts_with('-'))  // would look like an option
        words.push_back("--" + name + "=" + value);
      else
        words.insert(words.end(), {"--" + name, value});
  }
  return words;
}

}  // namespace latelight::app
