// Which clusters nothing could be seen of in the last frame, in device memory: what they hide behind is rasterized first, and
// the others are looked at again (Haar and Aaltonen 2015, GPU-Driven Rendering Pipelines, SIGGRAPH course). They are a
// guess: whatever they say, the picture is the same.
#pragma once

#include <array>
#include <memory>

#include "render/frame.h"

namespace latelight::render {

// Whose clusters: views with and without jitter, and those in which what is blended counts as solid, each have their own.
enum class HiddenOf { Steady, Jittered, WithBlended, Count };

class HiddenClusters {
 public:
  // `words`: uint32_t that all views of the frame take together. What is not known yet is all 0, which hides nothing.
  graph::BufferId addTo(const FrameContext& f, HiddenOf of, uint64_t words);

  // Of the last frame that has been looked at: how many clusters were rasterized of those in view, and how many of these
  // were not hidden in the frame before.
  struct Counts {
    uint32_t drawn = 0, seenBefore = 0;
  };
  Counts counts;

 private:
  struct Kept {
    std::shared_ptr<const vk::Buffer> buffer;  // in use by frames in flight, it lives on
    bool filled = false;
  };
  std::array<Kept, static_cast<size_t>(HiddenOf::Count)> kept_;
};

}  // namespace latelight::render
