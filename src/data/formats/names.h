// The names of objects that formats write.
#pragma once

#include <cstdint>
#include <string>

#include "output/id_manifest.h"

namespace latelight::data {

// Returns the path of the node that an id identifies; for a copy, a path such as "/Forest/Tree/instance3".
std::string nameOf(const output::IdEntry& entry);

}  // namespace latelight::data
