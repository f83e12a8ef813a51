#include "report/command.h"

#include <fmt/format.h>

#include "base/text.h"
#include "report/html.h"

namespace latelight::report {

namespace {

std::string quoted(std::string word) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./:,=+@%^-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  replaceAll(word, "'", "'\\''");
  return "'" + word + "'";
}

}  // namespace

std::string commandLine(std::span<const std::string> words) {
  std::string line = "latelight";
  for (const std::string& word : words) line.append(" ").append(quoted(word));
  return line;
}

std::string commandHtml(std::span<const std::string> words) {
  return fmt::format("<p class=\"command\"><code>{}</code></p>\n", escaped(commandLine(words)));
}

std::vector<std::string> joined(std::vector<std::string> words, std::span<const std::string> more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace latelight::report
