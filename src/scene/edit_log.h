// Records which elements of a list changed since a revision, so that copies of the list on devices can be updated. Each
// copy stores the revision that it contains. An element that changes again has a single entry, so the log does not grow
// without bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace latelight::scene {

class EditLog {
 public:
  void note(uint32_t index);  // if it throws, nothing has changed
  // Allocates what `count` calls of note() with indices below `elements` require, which then do not throw.
  void reserve(size_t elements, size_t count = 1);
  uint64_t revision() const { return revision_; }  // increases with every edit; 0: no edits
  // Returns the elements that changed after that revision, without duplicates, in ascending order.
  std::vector<uint32_t> since(uint64_t revision) const;

 private:
  struct Edit {
    uint64_t revision;
    uint32_t index;
  };
  void forgetOlder();
  uint64_t revision_ = 0;
  std::vector<Edit> edits_;     // by revision
  std::vector<uint64_t> last_;  // per element: its latest revision, 0 if it never changed
  size_t known_ = 0;            // number of elements that ever changed
};

}  // namespace latelight::scene
