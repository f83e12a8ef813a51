#pragma once

// The address sanitizer defines it in each program that is linked with it, whether or not the test itself is compiled
// with it (sanitized.cmake).
extern "C" [[gnu::weak]] void __asan_init();

inline bool hasAddressSanitizer() {
  return __asan_init != nullptr;
}
