// Stable ids of nodes, parts and materials: hashes of their names, so that they do not change when other elements are
// added or removed.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
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
  bool take(uint32_t id);              // false: it is 0 or already in use
  void release(uint32_t id) noexcept;  // makes a used id available again

 private:
  uint32_t& find(uint32_t id);
  void grow();

  std::vector<uint32_t> table_;  // a power of two, at most half full; 0: free
  size_t count_ = 0;
};

// Names of added elements and their ids: the name, or "<name>#<number>" with the lowest number from 2 on, whose id, the
// hash of it, is not in use. The numbers in use are not tried again, so that a million equal names require only a
// million steps.
class UniqueNames {
 public:
  bool take(uint32_t id) { return ids_.take(id); }  // of an element that was not added
  std::pair<std::string, uint32_t> make(const std::string& name);
  // Makes a used id available again. `name` is the element's name, with or without its number. If memory runs out, the
  // number stays in use.
  void release(uint32_t id, const std::string& name) noexcept;
  // Forgets the numbers in use, not the ids. Names made afterward depend only on the ids in use, even where the hashes
  // of different names are equal.
  void forgetNumbers() { numbers_.clear(); }

 private:
  struct Numbers {
    uint32_t next = 2;  // lower ones are in use, except for those that became free
    std::set<uint32_t> free;
  };
  void releaseNumber(const std::string& unique);

  UniqueIds ids_;
  std::unordered_map<std::string, Numbers> numbers_;    // by name
  std::unordered_map<uint32_t, std::string> numbered_;  // names with a number by their id
};

// Assigns each material its id, from its name or from "material<index>" if it has no name.
void identifyMaterials(Scene& scene);

// Throws Error(Usage) if both ways of grouping are requested.
void checkGrouping(const IdGrouping& grouping);

// Changes the ids of nodes and instances according to `grouping`. Throws Error(Usage) for a name that no node has.
void groupIds(Scene& scene, const IdGrouping& grouping);

}  // namespace latelight::scene
