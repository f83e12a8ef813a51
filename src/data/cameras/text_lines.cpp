#include "data/cameras/text_lines.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"

namespace latelight::data {

TextLines::TextLines(const std::filesystem::path& file) : file_(file) {
  const std::vector<std::byte> bytes = readFile(file);
  memory_.grow(2 * bytes.size(), fmt::format("the file '{}'", file.string()));
  text_.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::optional<std::string_view> TextLines::next() {
  if (at_ >= text_.size()) return std::nullopt;
  const size_t end = std::min(text_.find('\n', at_), text_.size());
  std::string_view line = std::string_view(text_).substr(at_, end - at_);
  at_ = end + 1;
  ++line_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::optional<std::string_view> TextLines::nextUsed() {
  while (const std::optional<std::string_view> line = next()) {
    const size_t first = line->find_first_not_of(" \t");
    if (first != line->npos && (*line)[first] != '#') return line;
  }
  return std::nullopt;
}

std::string TextLines::where() const {
  return fmt::format("line {} of {}", line_, file_.string());
}

std::vector<std::string_view> TextLines::words(std::string_view line, size_t least) const {
  std::vector<std::string_view> words;
  for (size_t begin = line.find_first_not_of(" \t"); begin != line.npos; begin = line.find_first_not_of(" \t", begin)) {
    const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  if (words.size() < least) badInput("{} has {} words, and must have {}", where(), words.size(), least);
  return words;
}

double TextLines::number(std::string_view word) const {
  const std::optional<double> value = parseNumber<double>(word);
  if (!value) badInput("{} has \"{}\" where a number must be", where(), word);
  return *value;
}

std::vector<double> TextLines::numbers(const std::vector<std::string_view>& words, size_t first, size_t count) const {
  std::vector<double> all;
  for (size_t i = first; i < first + count; ++i) all.push_back(number(words[i]));
  return all;
}

}  // namespace latelight::data
