// The cache of prefiltered environments, by the hash of their source.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "scene/environment/environment.h"

namespace latelight::scene {

// Returns nothing unless an entry has exactly the layout that this version stores for the key.
std::optional<Environment> restoreEnvironment(uint64_t key);
void storeEnvironment(uint64_t key, const Environment& environment);

std::string environmentCacheName(uint64_t key);

}  // namespace latelight::scene
