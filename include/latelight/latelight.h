// Latelight's public C++ API. No Vulkan type is in it, and nothing else is exported by the library.
#pragma once

#define LATELIGHT_API __attribute__((visibility("default")))

namespace latelight {

// The library's version, as in "0.1.0".
LATELIGHT_API const char* version();

}  // namespace latelight
