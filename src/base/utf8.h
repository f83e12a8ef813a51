// Decodes UTF-8, and converts text of other encodings to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace latelight {

struct Utf8Character {
  static constexpr uint32_t kInvalid = ~0u;

  uint32_t code = kInvalid;  // Unicode's code point
  size_t bytes = 1;
};

// Returns the first character of a non-empty text; kInvalid and one byte if it is not UTF-8 (Unicode 15, table 3-7).
Utf8Character firstUtf8Character(std::string_view text);

bool isUtf8(std::string_view text);

// Returns a text as it is if it is UTF-8. If it is not, its bytes are characters of Latin-1 (ISO/IEC 8859-1), the
// encoding of old programs, and are converted.
std::string utf8OrLatin1(std::string_view text);

}  // namespace latelight
