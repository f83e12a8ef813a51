// Unique hash ids, and their grouping by subtrees of nodes.
#include "scene/ids.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <new>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/log.h"
#include "scene/scene.h"

namespace latelight::scene {

uint32_t UniqueIds::make(uint32_t hash, const std::function<std::string()>& name) {
  uint32_t id = hash;
  for (unsigned attempt = 2; !take(id); ++attempt) id = hash32(fmt::format("{}~{}", name(), attempt));
  return id;
}

uint32_t UniqueIds::make(const std::string& name) {
  return make(hash32(name), [&] { return name; });
}

bool UniqueIds::take(uint32_t id) {
  if (id == 0) return false;
  if (2 * (count_ + 1) > table_.size()) grow();
  uint32_t& place = find(id);
  const bool isNew = std::exchange(place, id) != id;
  count_ += isNew;
  return isNew;
}

// Frees the slot, and moves entries that probed past it backwards (backward shift deletion).
void UniqueIds::release(uint32_t id) noexcept {
  if (table_.empty() || id == 0 || find(id) != id) return;
  const size_t mask = table_.size() - 1;
  auto hole = static_cast<size_t>(&find(id) - table_.data());
  for (size_t at = (hole + 1) & mask; table_[at] != 0; at = (at + 1) & mask) {
    const size_t home = table_[at] & mask;
    if (((at - home) & mask) < ((at - hole) & mask)) continue;
    table_[hole] = table_[at];
    hole = at;
  }
  table_[hole] = 0;
  --count_;
}

uint32_t& UniqueIds::find(uint32_t id) {
  size_t place = id & (table_.size() - 1);
  while (table_[place] != 0 && table_[place] != id) place = (place + 1) & (table_.size() - 1);
  return table_[place];
}

void UniqueIds::grow() {
  std::vector<uint32_t> old(std::max<size_t>(1024, table_.size() * 2));
  old.swap(table_);
  for (uint32_t id : old)
    if (id != 0) find(id) = id;
}

std::pair<std::string, uint32_t> UniqueNames::make(const std::string& name) {
  std::pair<std::string, uint32_t> made(name, hash32(name));
  if (ids_.take(made.second)) return made;
  Numbers& numbers = numbers_[name];
  for (bool isNew = false; !isNew;) {
    const uint32_t number = numbers.free.empty() ? numbers.next : *numbers.free.begin();
    made.first = fmt::format("{}#{}", name, number);
    made.second = hash32(made.first);
    isNew = ids_.take(made.second);
    try {
      if (isNew) numbered_[made.second] = made.first;
    } catch (...) {
      ids_.release(made.second);
      throw;
    }
    if (numbers.free.empty())
      ++numbers.next;
    else
      numbers.free.erase(numbers.free.begin());
  }
  return made;
}

void UniqueNames::release(uint32_t id, const std::string& name) noexcept {
  ids_.release(id);
  const auto known = numbered_.extract(id);
  try {
    releaseNumber(known.empty() ? name : known.mapped());
  } catch (const std::bad_alloc&) {  // later elements have other numbers
  }
}

void UniqueNames::releaseNumber(const std::string& unique) {
  const size_t mark = unique.rfind('#');
  if (mark == std::string::npos) return;
  const auto numbers = numbers_.find(unique.substr(0, mark));
  uint32_t number = 0;
  const auto [end, error] = std::from_chars(unique.data() + mark + 1, unique.data() + unique.size(), number);
  if (numbers == numbers_.end() || error != std::errc() || end != unique.data() + unique.size()) return;
  if (number >= 2 && number < numbers->second.next) numbers->second.free.insert(number);
}

void identifyMaterials(Scene& scene) {
  UniqueIds ids;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    Material& material = scene.materials[i];
    material.data.id = ids.make(material.name.empty() ? fmt::format("material{}", i) : material.name);
  }
}

namespace {

// Returns the nodes that pass their id to all their descendants.
std::vector<bool> nodesAtDepth(const Scene& scene, uint32_t depth) {
  std::vector<uint32_t> depths(scene.nodes.size());
  std::vector<bool> chosen(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const int parent = scene.nodes[i].parent;
    depths[i] = parent < 0 ? 0 : depths[size_t(parent)] + 1;
    chosen[i] = depths[i] == depth;
  }
  return chosen;
}

std::vector<bool> nodesCalled(const Scene& scene, const std::vector<std::string>& names) {
  std::unordered_map<std::string_view, bool> found;
  for (const std::string& name : names) found[name] = false;
  std::vector<bool> chosen(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i)
    for (const std::string_view name : {std::string_view(scene.nodes[i].name), std::string_view(scene.nodes[i].path)})
      if (const auto at = found.find(name); at != found.end()) chosen[i] = at->second = true;
  for (const std::string& name : names)
    if (!found[name])
      badUsage("{} has no node \"{}\" for --id-nodes: give names of its nodes, or paths such as /Root/Arm",
               printable(scene.source), printable(name));
  return chosen;
}

}  // namespace

void checkGrouping(const IdGrouping& grouping) {
  if (grouping.depth && !grouping.nodes.empty()) badUsage("--id-depth and --id-nodes both group ids; use one of them");
}

void groupIds(Scene& scene, const IdGrouping& grouping) {
  checkGrouping(grouping);
  if (!grouping.depth && grouping.nodes.empty()) return;
  const std::vector<bool> chosen =
      grouping.depth ? nodesAtDepth(scene, *grouping.depth) : nodesCalled(scene, grouping.nodes);
  std::vector<uint32_t> groups(scene.nodes.size());  // the id of each node's group, or 0
  for (size_t i = 0; i < scene.nodes.size(); ++i) {  // parents first
    Node& node = scene.nodes[i];
    groups[i] = chosen[i] ? node.id : node.parent < 0 ? 0 : groups[size_t(node.parent)];
    if (groups[i] != 0) node.id = groups[i];
  }
  for (Instance& instance : scene.instances)
    if (groups[instance.node] != 0) instance.id = groups[instance.node];
}

}  // namespace latelight::scene
