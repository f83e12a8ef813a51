#include "view/shell_words.h"

#include <fmt/format.h>

#include <string_view>

#include "base/text.h"

namespace latelight::view {

namespace {

std::string quoted(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=:,./+@%^";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = word;
  replaceAll(text, "'", "'\\''");
  return fmt::format("'{}'", text);
}

}  // namespace

std::string shellWords(std::span<const std::string> words) {
  std::string line;
  for (const std::string& word : words) line.append(line.empty() ? "" : " ").append(quoted(word));
  return line;
}

}  // namespace latelight::view
