// Images that persist from one frame of a sequence to the next. Each exists twice: a frame reads the last frame's while
// it writes its own.
#pragma once

#include <vector>

#include "render/frame/frame.h"
#include "vk/resources.h"

namespace latelight::render {

struct HistoryTarget {
  VkFormat format;
  const char* name;
};

class FrameHistory {
 public:
  explicit FrameHistory(std::vector<HistoryTarget> targets) : targets_(std::move(targets)) {}

  // Returns true if there is a frame of this size.
  bool fits(uint32_t width, uint32_t height, size_t views) const;
  uint32_t frames() const { return frames_; }        // since the history began
  void undo() { newest_ = 1 - newest_, --frames_; }  // reverts the last advance()
  void forget() { frames_ = 0; }                     // the next frame is the first one of a sequence

  // The next frame is the first one of a sequence.
  void begin(const FrameContext& f);
  struct Images {
    std::vector<graph::ImageId> last;  // of the last frame, in the order of the targets; empty in the first frame
    std::vector<graph::ImageId> next;  // of the frame, which has to write all of them
  };
  // Adds the images of the next frame to its graph. All frames after the first one have the first one's size.
  Images advance(const FrameContext& f);

 private:
  bool hasSize(uint32_t width, uint32_t height, size_t views) const;

  std::vector<HistoryTarget> targets_;
  std::vector<vk::Image> images_[2];
  uint32_t newest_ = 0, frames_ = 0;
};

}  // namespace latelight::render
