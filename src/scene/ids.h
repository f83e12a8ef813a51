// Ids of nodes, parts and materials: hashes of their names, so that they stay the same when others are added or
// removed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace latelight::scene {

struct IdGrouping;
struct Scene;

// Ids that are never 0 and unique: where two names have the same hash, the later one is hashed again with "~2" and so
// on appended. Taken ids are in one open-addressing table with linear probing, since there may be ten million.
class UniqueIds {
 public:
  // `hash` is hash32() of the name.
  uint32_t make(uint32_t hash, const std::function<std::string()>& name);
  uint32_t make(const std::string& name);
  bool take(uint32_t id);     // false: it is 0, or taken
  void release(uint32_t id);  // makes a taken id free again

 private:
  uint32_t& find(uint32_t id);
  void grow();

  std::vector<uint32_t> table_;  // a power of two, at most half full; 0: free
  size_t count_ = 0;
};

// Gives each material its id, from its name; one without a name is "material<index>".
void identifyMaterials(Scene& scene);

// Throws Error(Usage) where both ways of grouping are asked for.
void checkGrouping(const IdGrouping& grouping);

// Changes the ids of nodes and instances as asked. Throws Error(Usage) for a name that no node has.
void groupIds(Scene& scene, const IdGrouping& grouping);

}  // namespace latelight::scene
