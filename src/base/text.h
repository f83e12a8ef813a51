// Parses and formats numbers and lists as users read and write them.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace latelight {

// Parses the whole text as one finite number. Returns nothing if any part is not a number, or if it is out of range.
template <typename T>
std::optional<T> parseNumber(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

// "a, b or c"
inline std::string joinedByOr(std::span<const std::string> words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " or ") + words[i];
  return text;
}

// Returns the longest beginning of a UTF-8 text that has at most `size` bytes and ends with a whole character.
inline std::string_view utf8Beginning(std::string_view text, size_t size) {
  if (text.size() <= size) return text;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) --size;
  return text.substr(0, size);
}

// Returns the text, or, if it has more than `size` bytes, a beginning of it that ends with "...". It ends before a word
// unless that word is long.
inline std::string abbreviated(std::string_view text, size_t size) {
  constexpr size_t kLongWord = 30;
  const std::string_view ellipsis = "...";
  if (text.size() <= size || size < ellipsis.size()) return std::string(utf8Beginning(text, size));
  std::string_view beginning = utf8Beginning(text, size - ellipsis.size());
  const size_t space = text.substr(0, beginning.size() + 1).rfind(' ');
  if (space != text.npos && space + kLongWord > beginning.size()) beginning = text.substr(0, space);
  return std::string(beginning) + std::string(ellipsis);
}

// Replaces every occurrence of `from` by `to`.
inline void replaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

// Splits "a,b" into "a" and "b", and an empty text into one empty part. The parts point into `text`.
inline std::vector<std::string_view> splitAtCommas(std::string_view text) {
  std::vector<std::string_view> parts;
  for (size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',')) {
    parts.push_back(text.substr(0, comma));
    text.remove_prefix(comma + 1);
  }
  parts.push_back(text);
  return parts;
}

// Parses comma-separated numbers. Returns an empty list if any part is not a number.
template <typename T = float>
std::vector<T> parseNumbers(std::string_view text) {
  std::vector<T> values;
  for (std::string_view part : splitAtCommas(text)) {
    const std::optional<T> value = parseNumber<T>(part);
    if (!value) return {};
    values.push_back(*value);
  }
  return values;
}

}  // namespace latelight
