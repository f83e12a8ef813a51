// Records which elements of a list changed since a revision, so that copies of it on devices can follow: each copy
// remembers the revision that it has seen. An element that changes again has a single entry, so the log does not grow
// without bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace latelight::scene {

class EditLog {
 public:
  void note(uint32_t index);
  uint64_t revision() const { return revision_; }  // grows with every edit; 0: none so far
  // Elements that changed after that revision, each once, ascending.
  std::vector<uint32_t> since(uint64_t revision) const;

 private:
  struct Edit {
    uint64_t revision;
    uint32_t index;
  };
  void forgetOlder();
  uint64_t revision_ = 0;
  std::vector<Edit> edits_;     // by revision
  std::vector<uint64_t> last_;  // by index: its latest revision, 0 where it never changed
  size_t known_ = 0;            // elements that ever changed
};

}  // namespace latelight::scene
