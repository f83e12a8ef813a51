// Reads text files of words and numbers line by line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"

namespace latelight::data {

class TextLines {
 public:
  // Reads the whole file; throws Error(BadInput) if it cannot be read.
  explicit TextLines(const std::filesystem::path& file);

  // Returns the next line without its line break, or nullopt at the end of the file.
  std::optional<std::string_view> next();
  // Returns the next line that is neither blank nor a comment (#).
  std::optional<std::string_view> nextUsed();
  std::string where() const;  // "line 12 of FILE"

  // Split and convert the most recently read line. Throw Error(BadInput) with the line's number.
  std::vector<std::string_view> words(std::string_view line, size_t least) const;
  double number(std::string_view word) const;
  std::vector<double> numbers(const std::vector<std::string_view>& words, size_t first, size_t count) const;

 private:
  std::filesystem::path file_;
  std::string text_;
  MemoryClaim memory_;
  size_t at_ = 0, line_ = 0;
};

}  // namespace latelight::data
