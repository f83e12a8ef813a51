// Memory for the constants of graphs. It is host visible and allocated in chunks, which are reused once neither a graph
// nor a submission in flight needs them.
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
  bool hasCapacity(VkDeviceSize size) const { return used_ + size <= buffer_.size(); }
  VkDeviceAddress append(std::span<const std::byte> bytes);

 private:
  friend class ConstantPool;
  vk::Buffer buffer_;
  VkDeviceSize used_ = 0;
  uint64_t lastUse_ = 0;
};

// Any thread may take chunks. Dropping a chunk returns it to the pool.
class ConstantPool : public std::enable_shared_from_this<ConstantPool> {
 public:
  explicit ConstantPool(vk::Device& device) : device_(device) {}
  // Call this when a submission begins. It frees chunks that none of the last few submissions used.
  void tick();
  std::shared_ptr<ConstantChunk> take(VkDeviceSize size);

 private:
  void recycle(std::unique_ptr<ConstantChunk> chunk);
  vk::Device& device_;
  std::mutex mutex_;
  uint64_t now_ = 0;  // number of submissions so far
  std::vector<std::unique_ptr<ConstantChunk>> free_;
};

}  // namespace latelight::graph
