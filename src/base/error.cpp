#include "base/error.h"

#include "base/log.h"

namespace latelight {

std::string shortened(std::string_view text) {
  constexpr size_t kMax = 400, kHead = 200, kTail = 60;  // bytes
  if (text.size() <= kMax) return std::string(text);
  // Does not split UTF-8 characters.
  const auto within = [&](size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80; };
  size_t head = kHead, tail = text.size() - kTail;
  while (head > kHead - 4 && within(head)) --head;
  while (tail < text.size() - kTail + 4 && within(tail)) ++tail;
  return fmt::format("{} ... {} ({} bytes in all)", text.substr(0, head), text.substr(tail), text.size());
}

Error::Error(ExitCode code, const std::string& sentence) : std::runtime_error(printable(sentence)), code_(code) {}

Error::~Error() = default;  // defined here, so that the type can be caught across the library boundary

}  // namespace latelight
