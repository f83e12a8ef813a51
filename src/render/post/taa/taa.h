// Temporal anti-aliasing: jittered frames of a sequence, each blended into what the earlier ones left.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "render/frame.h"
#include "vk/resources.h"

namespace latelight::render {

// Frames that a still picture, and the first of a sequence, is the mean of; and the length of the jitter's cycle.
inline constexpr uint32_t kTemporalSamples = 16;

// Offsets from the pixel's centre, pixels: Halton's sequence in bases 2 and 3, less its mean.
const std::vector<glm::vec2>& temporalJitters();

// Of a frame; `motion`: MotionUse::Reproject.
struct TemporalSources {
  graph::ImageId picture, depth, motion;
};

// What one frame leaves to the next.
class TemporalHistory {
 public:
  // Whether there is one, of that size.
  bool fits(uint32_t width, uint32_t height, size_t views) const;
  uint32_t frames() const { return frames_; }        // since it began
  void undo() { newest_ = 1 - newest_, --frames_; }  // what the last frame left to it

 private:
  friend graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, TemporalHistory& history,
                                    bool begins);
  void begin(const FrameContext& f);

  vk::Image color_[2], state_[2];
  uint32_t newest_ = 0, frames_ = 0;
  bool filled_ = false;
};

// A history begins with the sum of kTemporalSamples frames, depth and motion those of the last; gives their mean. It
// goes on with a frame; gives the frame without its jitter's edges.
graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, TemporalHistory& history,
                           bool begins);

}  // namespace latelight::render
