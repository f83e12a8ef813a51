// The log of edited elements; see scene/edit_log.h.
#include "scene/edit_log.h"

#include <algorithm>

#include "base/reserve.h"

namespace latelight::scene {

void EditLog::reserve(size_t elements, size_t count) {
  if (last_.size() < elements) last_.resize(elements, 0);
  reserveMore(edits_, count);
}

void EditLog::note(uint32_t index) {
  reserve(size_t{index} + 1);
  known_ += last_[index] == 0;
  last_[index] = ++revision_;
  edits_.push_back({revision_, index});
  if (edits_.size() > 2 * known_ + 64) forgetOlder();
}

void EditLog::forgetOlder() {
  std::erase_if(edits_, [&](const Edit& edit) { return last_[edit.index] != edit.revision; });
}

std::vector<uint32_t> EditLog::since(uint64_t revision) const {
  std::vector<uint32_t> changed;
  for (auto edit = edits_.rbegin(); edit != edits_.rend() && edit->revision > revision; ++edit)
    changed.push_back(edit->index);
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  return changed;
}

}  // namespace latelight::scene
