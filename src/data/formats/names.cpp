#include "data/formats/names.h"

namespace latelight::data {

std::string nameOf(const output::IdEntry& entry) {
  return output::pathOf(entry.node, entry.copy);
}

}  // namespace latelight::data
