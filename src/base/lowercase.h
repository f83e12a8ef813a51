// Lower case of the letters of ASCII. Unlike std::tolower(), it does not depend on the locale, so files, names and
// identifiers are recognized alike on every machine.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace latelight {

constexpr char lowercase(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

inline std::string lowercase(std::string text) {
  for (char& c : text) c = lowercase(c);
  return text;
}

// Returns the extension by which a file's format is recognized: ".png" for "A.PNG", "" for names without one.
inline std::string lowercaseExtension(const std::filesystem::path& file) {
  return lowercase(file.extension().string());
}

}  // namespace latelight
