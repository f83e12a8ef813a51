// The secret in a server's address.
#pragma once

#include <string>
#include <string_view>

namespace latelight::serve {

std::string newToken();  // 128 random bits, as 32 hex digits

// Compares in constant time, independent of where the strings differ.
bool sameToken(std::string_view a, std::string_view b);

}  // namespace latelight::serve
