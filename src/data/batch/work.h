// The frames to be rendered, grouped by scene, and their distribution to workers.
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

// Frames that are rendered together, by index. They have the same scene, variation, picture size and scene time.
struct Chunk {
  uint32_t scene = 0, variation = 0;
  uint32_t width = 0, height = 0;
  std::vector<uint64_t> frames;
};

// The maximum number of views and pixels rendered together.
struct AtOnce {
  uint64_t views = 1, pixels = 0;  // a single view is always rendered, whatever its size
};

// Thread-safe. Each worker stays with one scene while it has work, so that scenes are loaded as rarely as possible.
class WorkList {
 public:
  // The frames in [first, end) that are not among `finished`.
  WorkList(const Plan& plan, uint64_t first, uint64_t end, const Manifest& finished, AtOnce most);

  uint64_t frames() const { return frames_; }
  // Assigns a scene with remaining work, except `except`, the worker's current scene. Scenes with the fewest workers
  // come first. Returns nullopt if no work remains.
  std::optional<uint32_t> claim(std::optional<uint32_t> except = {});
  void leave(uint32_t scene);  // releases a scene that the worker has claimed
  // Removes and returns the scene's next chunk; nullopt if none remains.
  std::optional<Chunk> take(uint32_t scene);
  // Removes and returns all remaining chunks of a scene that cannot be loaded.
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
