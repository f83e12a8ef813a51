// Two timestamps per pass; none where the queue does not support them.
#pragma once

#include <volk.h>

#include <cstdint>
#include <vector>

#include "vk/resources.h"

namespace latelight::graph {

class Timers {
 public:
  explicit Timers(vk::Device& device);
  // Outside render passes; before any mark().
  void begin(VkCommandBuffer commands, uint32_t passes);
  // The time when all work recorded so far is done.
  void mark(VkCommandBuffer commands, uint32_t index);
  // After the last mark(): copies the times to memory that the host reads. (vkGetQueryPoolResults waits for all
  // submissions of a CPU device, later ones too.)
  void end(VkCommandBuffer commands);
  // Milliseconds between the marks 2i and 2i + 1, of a submission that has finished.
  std::vector<double> read() const;

 private:
  vk::Device& device_;
  uint64_t mask_ = 0;  // of the valid bits; 0: no timestamps
  vk::Handle<VkQueryPool> pool_;
  vk::Buffer ticks_;  // 64 bits per mark
  uint32_t capacity_ = 0, marks_ = 0;
};

}  // namespace latelight::graph
