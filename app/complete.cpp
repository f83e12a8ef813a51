#include "app/complete.h"

#include <fmt/core.h>

#include <algorithm>

#include "app/commands.h"
#include "app/list.h"
#include "app/render_options.h"
#include "study/study.h"

namespace latelight::app {

namespace {

bool takesValue(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

// The context of the cursor: the command, and the option whose value is being typed.
struct CursorContext {
  const CLI::App* command;
  const CLI::Option* value = nullptr;
  size_t positionals = 0;  // count before the cursor
};

const CLI::App* commandNamed(const CLI::App& cli, const std::string& name) {
  const std::vector<const CLI::App*> found =
      cli.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

CursorContext cursorAfter(const CLI::App& cli, std::span<const std::string> words) {
  CursorContext cursor{&cli};
  for (const std::string& word : words) {
    if (std::exchange(cursor.value, nullptr)) continue;
    if (word.starts_with("-")) {
      const CLI::Option* option = cursor.command->get_option_no_throw(word);
      if (option && takesValue(*option)) cursor.value = option;
    } else if (const CLI::App* command = commandNamed(*cursor.command, word)) {
      cursor.command = command;
    } else {
      ++cursor.positionals;
    }
  }
  return cursor;
}

const render::Option* entryOf(const CLI::Option& option) {
  for (const std::span<const render::Option> table : {commandOptions(), render::options()})
    for (const render::Option& entry : table)
      if (option.check_name(std::string(render::longName(entry)))) return &entry;
  return nullptr;
}

// Returns the names that a value may have, or nothing if any text is possible.
std::vector<ListedName> namesFor(const CLI::App& command, const CLI::Option& option) {
  const std::string& name = option.get_name();
  std::vector<ListedName> names;
  if (command.get_name() == "list" && name == "TOPIC") {
    for (const std::string& topic : listTopics()) names.push_back({topic, ""});
  } else if (command.get_name() == "study" && name == "NAME") {
    for (const study::Study& study : study::studies()) names.push_back({study.name, study.description});
  } else if (command.get_name() == "completions" && name == "SHELL") {
    for (const std::string_view shell : completionShells()) names.push_back({std::string(shell), ""});
  } else if (name == "--device") {
    names = {{"auto", "a GPU if there is one"}, {"cpu", "the CPU"}};
  } else if (name == "--devices") {
    names = {{"auto", "a GPU if there is one"}, {"all", "all devices"}};
  } else if (name == "--debug") {
    names = {{"sheet", "all outputs except raw, samples and raster-*"},
             {"lights", "lights tested and used per pixel"},
             {"targets", "all targets of the layout"}};
    std::ranges::copy(listedNames("aovs"), std::back_inserter(names));
  } else if (const render::Option* entry = entryOf(option)) {
    for (const render::NamedOption& named : entry->names) names.push_back({named.name, named.description});
    if (names.empty()) names = listedNames(name == "SCENE" ? "scenes" : entry->topic);
  }
  return names;
}

// In a list, only the text after the last comma is completed.
void addNames(Completions& all, const std::vector<ListedName>& names, const std::string& begun) {
  const size_t comma = begun.rfind(',');
  const std::string before = comma == std::string::npos ? "" : begun.substr(0, comma + 1);
  for (const ListedName& name : names)
    if ((before + name.name).starts_with(begun)) all.words.push_back({before + name.name, name.description});
}

void addValues(Completions& all, const CLI::App& command, const CLI::Option& option, const std::string& begun) {
  const std::vector<ListedName> names = namesFor(command, option);
  addNames(all, names, begun);
  all.files = names.empty() || option.get_name() == "SCENE";
}

// Completes the value of a word such as "--tonemap=a". Returns false for other words.
bool addJoinedValues(Completions& all, const CLI::App& command, const std::string& begun) {
  const size_t equals = begun.find('=');
  if (!begun.starts_with("--") || equals == std::string::npos) return false;
  const CLI::Option* option = command.get_option_no_throw(begun.substr(0, equals));
  if (!option || !takesValue(*option)) return true;
  addValues(all, command, *option, begun.substr(equals + 1));
  for (Completion& value : all.words) value.word.insert(0, begun, 0, equals + 1);
  return true;
}

// Offers the options that the command accepts: its own, except hidden ones, and those that it passes to the program.
void addOptions(Completions& all, const CLI::App& command, const std::string& begun) {
  std::vector<const CLI::App*> sources{&command};
  const CLI::App* program = &command;
  while (program->get_parent()) program = program->get_parent();
  if (command.get_fallthrough()) sources.push_back(program);
  for (const CLI::App* from : sources)
    for (const CLI::Option* option : from->get_options())
      for (const std::string& name : option->get_lnames()) {
        const std::string word = "--" + name;
        const bool isListed = std::ranges::find(all.words, word, &Completion::word) != all.words.end();
        if (!option->get_group().empty() && !isListed && word.starts_with(begun))
          all.words.push_back({word, option->get_description()});
      }
}

}  // namespace

Completions complete(const CLI::App& cli, std::span<const std::string> words) {
  Completions all;
  const std::string begun = words.empty() ? "" : words.back();
  const CursorContext cursor = cursorAfter(cli, words.first(words.size() - !words.empty()));
  if (cursor.value) {
    addValues(all, *cursor.command, *cursor.value, begun);
  } else if (addJoinedValues(all, *cursor.command, begun)) {
    return all;
  } else if (begun.starts_with("-")) {
    addOptions(all, *cursor.command, begun);
  } else {
    for (const CLI::App* command : cursor.command->get_subcommands([](const CLI::App*) { return true; }))
      if (!command->get_group().empty() && command->get_name().starts_with(begun))
        all.words.push_back({command->get_name(), command->get_description()});
    const auto options = cursor.command->get_options([](const CLI::Option* o) { return o->get_positional(); });
    if (cursor.positionals < options.size()) addValues(all, *cursor.command, *options[cursor.positionals], begun);
    if (cursor.command->get_allow_extras()) all.files = true;  // further folders
  }
  return all;
}

void printCompletions(const CLI::App& cli, std::span<const std::string> words) {
  const Completions all = complete(cli, words);
  for (const Completion& each : all.words) fmt::print("{}\t{}\n", each.word, each.description);
  if (all.files) fmt::print(":files\n");
}

}  // namespace latelight::app
