// Converts JSON to text and back, even if its names are not UTF-8.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace latelight::data {

// Serializes to one line. Names come from files and may be invalid UTF-8; invalid bytes are replaced.
inline std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

inline nlohmann::ordered_json parsed(std::span<const std::byte> bytes) {
  const char* text = reinterpret_cast<const char*>(bytes.data());
  return nlohmann::ordered_json::parse(text, text + bytes.size());
}

// Returns the message of an exception of nlohmann::json without its name in the library, which begins as in
// "[json.exception.type_error.302] type must be string".
inline std::string reasonOf(const nlohmann::ordered_json::exception& error) {
  const std::string what = error.what();
  const size_t end = what.starts_with('[') ? what.find("] ") : std::string::npos;
  return end == std::string::npos ? what : what.substr(end + 2);
}

// Formats a hash for JSON as 16 hexadecimal digits, because not every JSON reader preserves 64-bit numbers.
inline std::string hashText(uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace latelight::data
