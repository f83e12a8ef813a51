// Names and lookup, shared by the registries of layouts, encodings and techniques.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "base/error.h"

namespace latelight::render {

// Converts the name of a file or folder to the name that users write: forward_multipass becomes "forward-multipass".
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

// Returns the entry with that name, or throws Error(Usage) that lists the names.
template <typename Range>
auto& findByName(const Range& range, std::string_view name, std::string_view what) {
  for (const auto& entry : range)
    if (entry.name == name) return entry;
  badUsage("there is no {} \"{}\"; there are: {}", what, name, namesOf(range));
}

// Returns the entry with the name that an option was given, or throws Error(Usage) that begins with the option.
template <typename Range>
auto& entryNamed(const char* option, const Range& registry, std::string_view name) {
  for (const auto& entry : registry)
    if (entry.name == name) return entry;
  badUsage("{} takes one of these, not \"{}\": {}", option, name, namesOf(registry));
}

}  // namespace latelight::render
