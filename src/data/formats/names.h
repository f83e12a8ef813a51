// Names of what ids stand for, as formats write them.
#pragma once

#include <cstdint>
#include <string>

#include "output/id_manifest.h"

namespace latelight::data {

// The node's path; of a copy "/Forest/Tree/instance3".
std::string nameOf(const output::IdEntry& entry);

}  // namespace latelight::data
