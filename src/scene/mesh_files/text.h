// Reads numbers and words of text files from memory.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/lowercase.h"

namespace latelight::scene::mesh_files {

inline bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

// Returns the number of the line that contains the byte at `offset`, from 1 on. Lines end with LF, CR LF or CR.
inline size_t lineAt(std::string_view text, size_t offset) {
  size_t line = 1;
  for (size_t i = 0; i < std::min(offset, text.size()); ++i)
    if (text[i] == '\n' || (text[i] == '\r' && text.substr(i + 1, 1) != "\n")) ++line;
  return line;
}

// Parses a number at the start of [at, end), and returns the end of it, or null if there is none. Values beyond the
// range of floats become 0 or infinite. "nan" and "inf" are numbers, as printf writes them.
inline const char* parseFloat(const char* at, const char* end, float& value) {
  if (at < end && *at == '+') ++at;
  const auto result = std::from_chars(at, end, value);
  if (result.ec == std::errc()) return result.ptr;
  if (result.ec != std::errc::result_out_of_range) return nullptr;
  double wide = 0;
  if (std::from_chars(at, end, wide).ec == std::errc::result_out_of_range)  // a magnitude beyond that of doubles, too
    wide = std::find(at, result.ptr, '-') == result.ptr ? std::numeric_limits<double>::infinity() : 0;
  value = static_cast<float>(wide);
  return result.ptr;
}

// A line of a text file, or a whole file if line ends count as blanks.
class Words {
 public:
  explicit Words(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

  void skipBlanks() {
    while (at_ < end_ && (isBlank(*at_) || *at_ == '\n')) ++at_;
  }
  bool isAtEnd() {
    skipBlanks();
    return at_ == end_;
  }
  const char* position() const { return at_; }
  // Returns the next word; empty at the end.
  std::string_view word() {
    skipBlanks();
    const char* begin = at_;
    while (at_ < end_ && !isBlank(*at_) && *at_ != '\n') ++at_;
    return {begin, static_cast<size_t>(at_ - begin)};
  }
  // Returns the next word of the line, which LF or CR ends; empty at the line's end.
  std::string_view wordOnLine() {
    while (at_ < end_ && isBlank(*at_) && *at_ != '\r') ++at_;
    return at_ < end_ && (*at_ == '\r' || *at_ == '\n') ? std::string_view() : word();
  }
  // Returns the rest without blanks at its ends.
  std::string_view rest() {
    skipBlanks();
    const char* last = end_;
    while (last > at_ && (isBlank(last[-1]) || last[-1] == '\n')) --last;
    return {at_, static_cast<size_t>(last - at_)};
  }
  // Parses the next word as a number. Returns false, and does not move, if it is not one.
  bool number(float& value) {
    skipBlanks();
    const char* after = parseFloat(at_, end_, value);
    if (!after || (after < end_ && !isBlank(*after) && *after != '\n')) return false;
    at_ = after;
    return true;
  }
  bool number(int64_t& value) {
    skipBlanks();
    const char* begin = at_ < end_ && *at_ == '+' ? at_ + 1 : at_;
    const auto [after, error] = std::from_chars(begin, end_, value);
    if (error != std::errc() || (after < end_ && !isBlank(*after) && *after != '\n')) return false;
    at_ = after;
    return true;
  }

 private:
  const char* at_;
  const char* end_;
};

// Returns the text of a file without the byte-order mark of UTF-8, which some editors write.
inline std::string_view withoutByteOrderMark(std::string_view text) {
  return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

// Returns a file's name without the quotation marks that some writers put around it.
inline std::string_view unquoted(std::string_view name) {
  const bool isQuoted = name.size() > 2 && name.front() == '"' && name.back() == '"';
  return isQuoted ? name.substr(1, name.size() - 2) : name;
}

// Returns true if two words are equal, regardless of the case of ASCII letters. `lower` is in lower case.
inline bool equalsIgnoringCase(std::string_view word, std::string_view lower) {
  return std::ranges::equal(word, lower, [](char a, char b) { return lowercase(a) == b; });
}

}  // namespace latelight::scene::mesh_files
