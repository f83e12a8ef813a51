// Hashes that are equal on every machine and in every version.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace latelight {

// FNV-1a, 32 bits (Fowler, Noll, Vo), for short strings and ids in outputs.
constexpr uint32_t hash32(std::string_view text) {
  uint32_t h = 0x811c9dc5u;
  for (char c : text) h = (h ^ static_cast<uint8_t>(c)) * 0x01000193u;
  return h;
}

// XXH3, 64 bits, for file contents and cache keys.
uint64_t hash64(const void* data, size_t bytes, uint64_t seed = 0);

}  // namespace latelight
