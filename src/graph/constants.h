// Memory for a graph's constants: host visible, in chunks that are reused once neither a graph nor a submission in
// flight needs them.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "vk/resources.h"

namespace latelight::graph {

class ConstantChunk {
 public:
  ConstantChunk(vk::Device& device, VkDeviceSize size);
  bool hasRoom(VkDeviceSize size) const { return used_ + size <= buffer_.size(); }
  VkDeviceAddress append(std::span<const std::byte> bytes);

 private:
  friend class ConstantPool;
  vk::Buffer buffer_;
  VkDeviceSize used_ = 0;
  uint64_t lastUse_ = 0;
};

// Any thread may take chunks, and return them by dropping them.
class ConstantPool : public std::enable_shared_from_this<ConstantPool> {
 public:
  explicit ConstantPool(vk::Device& device) : device_(device) {}
  // A submission begins: frees chunks that none of the last few took.
  void tick();
  std::shared_ptr<ConstantChunk> take(VkDeviceSize size);

 private:
  void giveBack(std::unique_ptr<ConstantChunk> chunk);
  vk::Device& device_;
  std::mutex mutex_;
  uint64_t now_ = 0;  // submissions so far
  std::vector<std::unique_ptr<ConstantChunk>> free_;
};

}  // namespace latelight::graph
