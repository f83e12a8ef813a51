#include "base/utf8.h"

namespace latelight {

Utf8Character firstUtf8Character(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  constexpr uint32_t kMin[] = {0x80, 0x800, 0x10000};
  uint32_t code = lead & (0x7fu >> bytes);
  for (size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  if (lead < 0xc2 || lead > 0xf4 || code < kMin[bytes - 2] || code > 0x10ffff || surrogate) return {};
  return {code, bytes};
}

bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    const Utf8Character character = firstUtf8Character(text);
    if (character.code == Utf8Character::kInvalid) return false;
    text.remove_prefix(character.bytes);
  }
  return true;
}

std::string utf8OrLatin1(std::string_view text) {
  if (isUtf8(text)) return std::string(text);
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x80) result += static_cast<char>(0xc0 | code >> 6);
    result += static_cast<char>(code < 0x80 ? code : 0x80 | (code & 0x3f));
  }
  return result;
}

}  // namespace latelight
