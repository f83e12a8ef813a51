// Shell completion: the words that fit at the cursor, derived from the command line's own description.
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
  std::vector<Completion> words;  // words that begin like the last word
  bool files = false;             // file names fit as well
};

// `words` are the words after the program's name. The last one is to be completed and may be empty.
Completions complete(const CLI::App& cli, std::span<const std::string> words);

// Implements `latelight complete -- WORDS` for the scripts of `latelight completions`. Prints one line per word: the
// word, a tab and its description; ":files" stands for file names.
void printCompletions(const CLI::App& cli, std::span<const std::string> words);

}  // namespace latelight::app
