#include "data/formats/names.h"

#include <algorithm>

namespace latelight::data {

const output::IdEntry* entryOf(const output::IdManifest& ids, uint32_t id) {
  const auto found = std::ranges::lower_bound(ids.ids, id, {}, &output::IdEntry::id);
  return found == ids.ids.end() || found->id != id ? nullptr : &*found;
}

std::string nameOf(const output::IdEntry& entry) {
  return output::pathOf(entry.node, entry.copy);
}

}  // namespace latelight::data
