// GPU timers: two timestamps per pass, or none if the queue does not support them.
#pragma once

#include <volk.h>

#include <cstdint>
#include <vector>

#include "vk/resources.h"

namespace latelight::graph {

class Timers {
 public:
  explicit Timers(vk::Device& device);
  // Call it outside render passes, before any mark().
  void begin(VkCommandBuffer commands, uint32_t passes);
  // Writes the time at which all commands recorded so far have finished.
  void mark(VkCommandBuffer commands, uint32_t index);
  // Call it after the last mark(). It copies the times to memory that the host reads, because vkGetQueryPoolResults on
  // a CPU device waits for all submissions, including later ones.
  void end(VkCommandBuffer commands);
  // Returns the milliseconds between the marks 2i and 2i + 1, of a submission that has finished.
  std::vector<double> read() const;

 private:
  vk::Device& device_;
  uint64_t mask_ = 0;  // mask of the valid timestamp bits; 0: no timestamps
  vk::Handle<VkQueryPool> pool_;
  vk::Buffer ticks_;  // 64 bits per mark
  uint32_t capacity_ = 0, marks_ = 0;
};

}  // namespace latelight::graph
