// Shared by the registries of layouts, encodings, techniques, ...: names and lookup.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "base/error.h"

namespace latelight::render {

// A file's or folder's name as users write it: forward_multipass is "forward-multipass".
inline std::string registryName(std::string_view file) {
  std::string name(file);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

template <typename Range>
std::string namesOf(const Range& range) {
  std::string names;
  for (const auto& entry : range) names += (names.empty() ? "" : ", ") + std::string(entry.name);
  return names;
}

// The entry of that name, or Error(Usage) that lists the names.
template <typename Range>
auto& findByName(const Range& range, std::string_view name, std::string_view what) {
  for (const auto& entry : range)
    if (entry.name == name) return entry;
  badUsage("there is no {} \"{}\"; there are: {}", what, name, namesOf(range));
}

}  // namespace latelight::render
