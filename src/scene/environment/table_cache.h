// Cached tables over n.v and roughness, which are computed once.
#pragma once

#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/files.h"

namespace latelight::scene {

// Returns the `count` entries of that name in the cache, or those that compute() returns. The name must identify all
// inputs.
template <typename Entry, typename Compute>
std::vector<Entry> cachedTable(const std::string& name, size_t count, Compute compute) {
  const std::optional<std::vector<std::byte>> entry = loadCache(name);
  if (entry && entry->size() == sizeof(Entry) * count) {
    std::vector<Entry> table(count);
    std::memcpy(table.data(), entry->data(), entry->size());
    return table;
  }
  const std::vector<Entry> table = compute();
  storeCache(name, std::as_bytes(std::span(table)));
  return table;
}

}  // namespace latelight::scene
