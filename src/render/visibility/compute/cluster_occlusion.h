// Which clusters nothing could be seen of in the last frame, in device memory: what they hide behind is rasterized
// first, and the others are looked at again (Haar and Aaltonen 2015, GPU-Driven Rendering Pipelines, SIGGRAPH course).
// They are a guess: whatever they say, the picture is the same.
#pragma once

#include <array>
#include <memory>

#include "render/frame/frame.h"

namespace latelight::render {

// Whose clusters: views with and without jitter, and those in which what is blended counts as solid, each have their
// own.
enum class HiddenOf { Steady, Jittered, WithBlended, Count };

class ClusterOcclusion {
 public:
  // Whether the next frame had better look for what is hidden, of so many clusters in all views: where they are many,
  // some frames find out, and the others follow if enough of them were hidden.
  bool shouldCull(const vk::Device& device, HiddenOf of, uint64_t clusters);
  // `words`: uint32_t that all views of the frame take together. What is not known yet is all 0, which hides nothing.
  graph::BufferId addTo(const FrameContext& f, HiddenOf of, uint64_t words);

  // Of the last frame that looked: how many clusters were rasterized though they were hidden in the frame before, and
  // how many are hidden now.
  struct Counts {
    uint32_t found = 0, hidden = 0;
  };
  const Counts& counts(HiddenOf of) const { return kept_[static_cast<size_t>(of)].counts; }
  void keep(HiddenOf of, uint32_t found, uint32_t hidden) { kept_[static_cast<size_t>(of)].counts = {found, hidden}; }

 private:
  struct Kept {
    std::shared_ptr<const vk::Buffer> buffer;  // in use by frames in flight, it lives on
    bool filled = false;
    uint32_t frames = 0;  // since one found out
    Counts counts;
  };
  std::array<Kept, static_cast<size_t>(HiddenOf::Count)> kept_;
};

}  // namespace latelight::render
