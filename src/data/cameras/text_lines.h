// Text files of words and numbers, line by line.
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
  // The whole file; throws Error(BadInput) where it can't be read.
  explicit TextLines(const std::filesystem::path& file);

  // The next line, without its end, or nothing.
  std::optional<std::string_view> next();
  // The same, past empty ones and comments (#).
  std::optional<std::string_view> nextUsed();
  std::string where() const;  // "line 12 of FILE"

  // Of the line read last; throw Error(BadInput).
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
