// What is to be rendered, scene by scene, and who takes it.
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "base/memory.h"
#include "data/batch/manifest.h"
#include "data/batch/plan.h"

namespace latelight::data {

// Frames that are rendered at once: of one scene, variation, size and moment, by index.
struct Chunk {
  uint32_t scene = 0, variation = 0;
  uint32_t width = 0, height = 0;
  std::vector<uint64_t> frames;
};

// How much is rendered at once, at most.
struct AtOnce {
  uint64_t views = 1, pixels = 0;  // at least a view
};

// From any thread. Workers keep to a scene, so that each is loaded as seldom as can be.
class WorkList {
 public:
  // The frames in [first, end) that are not among `finished`.
  WorkList(const Plan& plan, uint64_t first, uint64_t end, const Manifest& finished, AtOnce most);

  uint64_t frames() const { return frames_; }
  // A scene with work left, other than the one that the worker has; those with the fewest workers first. Nothing: all
  // is taken.
  std::optional<uint32_t> claim(std::optional<uint32_t> except = {});
  void leave(uint32_t scene);  // by a worker that claimed it
  // The next of the scene's; nothing: all are taken.
  std::optional<Chunk> take(uint32_t scene);
  // All that is left of it: it can't be loaded.
  std::vector<Chunk> drop(uint32_t scene);

 private:
  struct SceneWork {
    std::deque<Chunk> chunks;
    uint32_t workers = 0;
  };
  std::mutex mutex_;
  std::vector<SceneWork> scenes_;
  uint64_t frames_ = 0;
  MemoryClaim memory_;
};

}  // namespace latelight::data
