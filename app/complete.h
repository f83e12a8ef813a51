// What may stand where a shell's cursor is: words of the command line, from its own description.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <vector>

namespace latelight::app {

struct Completion {
  std::string word, description;
};

struct Completions {
  std::vector<Completion> words;  // that begin as the last word does
  bool files = false;             // and names of files
};

// `words`: those after the program's name, the last being the one to complete, perhaps empty.
Completions complete(const CLI::App& cli, std::span<const std::string> words);

// `latelight complete -- WORDS`, for the scripts of `latelight completions`. A line each: the word, a tab, what it is;
// ":files" for names of files.
void printCompletions(const CLI::App& cli, std::span<const std::string> words);

}  // namespace latelight::app
