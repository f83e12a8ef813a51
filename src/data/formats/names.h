// The names of objects that formats write.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "output/id_manifest.h"

namespace latelight::data {

// Returns the path of the node that an id identifies; for a copy, a path such as "/Forest/Tree/instance3".
std::string nameOf(const output::IdEntry& entry);

// Returns a name, in UTF-8, as one word: "_" replaces each control character and each white space character of Unicode,
// at which readers of text files split lines and columns.
std::string asWord(std::string_view name);

}  // namespace latelight::data
