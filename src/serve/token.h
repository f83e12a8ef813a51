// The secret in a server's address.
#pragma once

#include <string>
#include <string_view>

namespace latelight::serve {

std::string newToken();  // 128 random bits, as 32 hex digits

// In a time that does not depend on where they differ.
bool sameToken(std::string_view a, std::string_view b);

}  // namespace latelight::serve
