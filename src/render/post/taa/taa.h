// Temporal anti-aliasing: jittered frames of a sequence, each blended into the history of earlier ones.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "render/frame.h"
#include "vk/resources.h"

namespace latelight::render {

// The number of frames averaged for a still picture and for the first of a sequence, and the length of the jitter
// cycle.
inline constexpr uint32_t kTemporalSamples = 16;

// Offsets from the pixel's centre, pixels: the Halton sequence in bases 2 and 3, minus its mean.
const std::vector<glm::vec2>& temporalJitters();

// Images of a frame; `motion`: MotionUse::Reproject.
struct TemporalSources {
  graph::ImageId picture, depth, motion;
};

// The history that one frame leaves to the next.
class TemporalHistory {
 public:
  // Whether there is one, of that size.
  bool fits(uint32_t width, uint32_t height, size_t views) const;
  uint32_t frames() const { return frames_; }        // since it began
  void undo() { newest_ = 1 - newest_, --frames_; }  // reverts the last frame's update

 private:
  friend graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, TemporalHistory& history,
                                    bool begins);
  void begin(const FrameContext& f);

  vk::Image color_[2], state_[2];
  uint32_t newest_ = 0, frames_ = 0;
  bool filled_ = false;
};

// A history begins with the sum of kTemporalSamples frames, with depth and motion of the last; the result is their
// mean. It continues with single frames; the result is the anti-aliased frame.
graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, TemporalHistory& history,
                           bool begins);

}  // namespace latelight::render
