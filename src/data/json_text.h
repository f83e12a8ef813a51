// JSON as text and back, whatever names it holds.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace latelight::data {

// On one line. Names come from files and need not be UTF-8.
inline std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

inline nlohmann::ordered_json parsed(std::span<const std::byte> bytes) {
  const char* text = reinterpret_cast<const char*>(bytes.data());
  return nlohmann::ordered_json::parse(text, text + bytes.size());
}

// Hashes in JSON: 16 digits, since not every reader keeps 64-bit numbers.
inline std::string hashText(uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace latelight::data
