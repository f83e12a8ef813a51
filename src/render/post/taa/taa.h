// Temporal anti-aliasing: jittered frames of a sequence, each blended into what the earlier ones left.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "render/frame.h"
#include "vk/pipeline.h"
#include "vk/resources.h"

namespace latelight::render {

// Frames that a still picture, and the first of a sequence, is the mean of; and the length of the jitter's cycle.
inline constexpr uint32_t kTemporalSamples = 16;

// Offsets from the pixel's centre, pixels: Halton's sequence in bases 2 and 3, less its mean.
const std::vector<glm::vec2>& temporalJitters();

// What one frame leaves to the next.
class TemporalHistory {
 public:
  // Whether there is one, of that size.
  bool fits(uint32_t width, uint32_t height, size_t views) const;
  uint32_t frames() const { return frames_; }        // since it began
  void undo() { newest_ = 1 - newest_, --frames_; }  // what the last frame left to it

 private:
  friend class TemporalPass;
  vk::Image color_[2], state_[2];
  uint32_t newest_ = 0, frames_ = 0;
  bool filled_ = false;
};

class TemporalPass {
 public:
  explicit TemporalPass(vk::Device& device);

  // Of a frame; `motion`: MotionUse::Reproject.
  struct Sources {
    graph::ImageId picture, depth, motion;
  };
  // A history begins with the sum of kTemporalSamples frames, depth and motion those of the last. Gives their mean.
  graph::ImageId begin(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources,
                       TemporalHistory& history) const;
  // It goes on with a frame. Gives the frame without its jitter's edges.
  graph::ImageId resume(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources,
                        TemporalHistory& history) const;

 private:
  struct Old {
    graph::ImageId color, state;
  };
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs, const Sources& sources, const Old& old,
                     TemporalHistory& history) const;

  vk::Device& device_;
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> nearest_, linear_;
};

}  // namespace latelight::render
