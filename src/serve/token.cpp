#include "serve/token.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/random.h>

#include <array>
#include <cerrno>

#include "base/error.h"

namespace latelight::serve {

std::string newToken() {
  std::array<unsigned char, 16> bytes{};
  ssize_t got = -1;
  do got = getrandom(bytes.data(), bytes.size(), 0);
  while (got < 0 && errno == EINTR);
  if (got != static_cast<ssize_t>(bytes.size())) fail(ExitCode::Internal, "the system provides no random bytes");
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool sameToken(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char different = 0;
  for (size_t i = 0; i < a.size(); ++i) different |= static_cast<unsigned char>(a[i] ^ b[i]);
  return different == 0;
}

}  // namespace latelight::serve
