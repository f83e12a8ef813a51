#include "view/choice.h"

#include <algorithm>

#include "base/error.h"
#include "render/gbuffer/layout.h"
#include "render/options/options.h"
#include "render/submit/session.h"

namespace latelight::view {

namespace {

const render::Option& findOption(std::string_view name) {
  const std::string_view key = name.substr(std::min(name.find_first_not_of('-'), name.size()));
  for (const render::Option& option : render::options())
    if (render::keyOf(option) == key && key != "size") return option;
  badUsage("there is no option \"{}\"; latelight list options shows all", name);
}

// Returns false for options without effect: animation options without a time, and options whose value the layout fixes.
bool meansSomething(std::string_view key, const Choice& choice, const render::Layout& layout) {
  if (key == "animation" || key == "loop") return choice.options.contains("time");
  if (key == "normals") return !layout.fixedNormal;
  if (key == "position") return !layout.fixedPosition;
  return true;
}

}  // namespace

ChosenSettings settingsOf(const Choice& choice, uint32_t width, uint32_t height) {
  ChosenSettings chosen;
  render::Settings& s = chosen.settings;
  for (const auto& [key, text] : choice.options) render::read(s, findOption(key), text);
  s.width = width, s.height = height;
  if (choice.output != "picture") {
    chosen.debug = output::parseDebug(choice.output, s.time.has_value());
    render::showDebug(s, *chosen.debug);
  }
  render::checkSettings(s);
  return chosen;
}

Choice withOption(const Choice& choice, std::string_view name, std::string_view value) {
  const render::Option& option = findOption(name);
  const std::string key(render::keyOf(option));
  Choice changed = choice;
  const bool off = value.empty() || (option.kind == render::OptionKind::Flag && value == "false");
  if (off || value == option.defaultValue)
    changed.options.erase(key);
  else
    changed.options.insert_or_assign(key, value);
  settingsOf(changed, 1, 1);
  return changed;
}

Choice withOutput(const Choice& choice, std::string_view output) {
  Choice changed = choice;
  changed.output = output;
  settingsOf(changed, 1, 1);
  return changed;
}

std::vector<std::string> wordsOf(const Choice& choice) {
  const render::Layout& layout = *settingsOf(choice, 1, 1).settings.layout;
  std::vector<std::string> words;
  for (const auto& [key, text] : choice.options) {
    const render::Option& option = findOption(key);
    if (!meansSomething(key, choice, layout)) continue;
    const bool flag = option.kind == render::OptionKind::Flag;
    // A value that begins with a dash would be read as an option.
    words.push_back(flag ? option.name : std::string(option.name) + "=" + text);
  }
  if (choice.output != "picture") words.push_back("--debug=" + choice.output);
  return words;
}

}  // namespace latelight::view
