// Stable ids of nodes, parts and materials: hashes of their names, so that they do not change when other elements are
// added or removed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace latelight::scene {

struct IdGrouping;
struct Scene;

// Unique ids that are never 0. If two names have the same hash, the later one is hashed again with "~2" and so on
// appended. Used ids are in one open-addressing table with linear probing, because there may be ten million.
class UniqueIds {
 public:
  // `hash` is hash32() of the name.
  uint32_t make(uint32_t hash, const std::function<std::string()>& name);
  uint32_t make(const std::string& name);
  bool take(uint32_t id);     // false: it is 0 or already in use
  void release(uint32_t id);  // makes a used id available again

 private:
  uint32_t& find(uint32_t id);
  void grow();

  std::vector<uint32_t> table_;  // a power of two, at most half full; 0: free
  size_t count_ = 0;
};

// Assigns each material its id, from its name or from "material<index>" if it has no name.
void identifyMaterials(Scene& scene);

// Throws Error(Usage) if both ways of grouping are requested.
void checkGrouping(const IdGrouping& grouping);

// Changes the ids of nodes and instances according to `grouping`. Throws Error(Usage) for a name that no node has.
void groupIds(Scene& scene, const IdGrouping& grouping);

}  // namespace latelight::scene
