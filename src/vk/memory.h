// Device memory allocator. It suballocates from blocks per memory type, of 64 MiB in the memory of GPUs and of 1 to 64
// MiB in that of the host, with linear and optimal resources in separate blocks. Render targets and large resources
// have dedicated allocations. Host-visible blocks are persistently mapped. Buffers of CPU devices have a window of
// their own (texel_window.h).
#pragma once

#include <volk.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "vk/deletion.h"

namespace latelight::vk {

class Device;
class TexelWindow;

// Offsets inside one block: first fit over a sorted free list, neighbors are merged on free. It does not use Vulkan, so
// that it can be tested without a device.
class BlockRanges {
 public:
  explicit BlockRanges(uint64_t size);
  // Returns an offset that is a multiple of `alignment` (a power of two), or kNone if no free range is large enough.
  static constexpr uint64_t kNone = ~uint64_t{0};
  uint64_t allocate(uint64_t size, uint64_t alignment);
  void release(uint64_t offset) noexcept;
  bool empty() const;
  uint64_t freeBytes() const;
  uint64_t largestFree() const;

 private:
  using Ranges = std::map<uint64_t, uint64_t>;  // offset -> size
  void use(Ranges::iterator range, uint64_t offset, uint64_t size);
  Ranges free_, used_;
};

enum class MemoryKind {
  Device,    // device local; on CPU devices also host visible, at no cost
  Upload,    // host visible, coherent: written once by the host, read by the device
  Readback,  // host visible, cached: written by the device, read by the host
};

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = 0;
  std::byte* mapped = nullptr;  // host-visible memory only
  void* block = nullptr;        // private to the allocator
  bool outside = false;         // of the texel window, which had no space for it
};

class Allocator {
 public:
  static constexpr VkDeviceSize kBlockSize = VkDeviceSize{64} << 20;

  explicit Allocator(Device& device);
  ~Allocator();
  enum class Sharing : uint8_t {
    Blocks,     // small resources share blocks
    Dedicated,  // a dedicated allocation
    Exported,   // a dedicated allocation that other APIs can import
    Window,     // in the texel window if the device has one with space for it; else in blocks
  };
  // Throws Error(OutOfMemory), with the sizes in the message, if the device is out of memory.
  Allocation allocate(const VkMemoryRequirements& needs, MemoryKind kind, bool linear, Sharing sharing);
  // Returns the memory type of such an allocation.
  uint32_t typeFor(const VkMemoryRequirements& needs, MemoryKind kind) const;
  void release(const Allocation& allocation);
  const TexelWindow* window() const { return window_.get(); }  // null: the device has none
  // Returns true if all allocations for the window are in it.
  bool isAllInWindow() const { return window_ && outside_ == 0; }
  struct Statistics {
    uint64_t blocks = 0, allocations = 0, reservedBytes = 0, usedBytes = 0;
  };
  Statistics statistics() const;

 private:
  struct Block;
  Allocation allocateShared(const VkMemoryRequirements& needs, MemoryKind kind, bool linear, Sharing sharing);
  Allocation take(Block& block, const VkMemoryRequirements& needs);  // memory is null if the block has no space
  VkDeviceSize nextBlockSize(const VkMemoryRequirements& needs, uint32_t type, bool linear) const;
  Block& addBlock(VkDeviceSize size, uint32_t type, bool linear, Sharing sharing);
  VkDeviceSize reserved() const;
  [[noreturn]] void failFull(VkDeviceSize size, VkDeviceSize room) const;
  Device& device_;
  VkPhysicalDeviceMemoryProperties properties_{};
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::unique_ptr<TexelWindow> window_;
  std::atomic<uint64_t> outside_ = 0;  // allocations for which the window had no space
};

// Device memory to which several resources are bound, at offsets that their owner chooses. Resources that are never in
// use at the same time may overlap (memory aliasing). Destruction is deferred. It contains both buffers and images, so
// offsets and sizes are multiples of bufferImageGranularity.
class Heap {
 public:
  Heap(Device& device, uint32_t type, VkDeviceSize size, VkDeviceSize alignment);
  ~Heap();
  Heap(const Heap&) = delete;
  Heap& operator=(const Heap&) = delete;

  uint32_t type() const { return type_; }
  VkDeviceSize size() const { return allocation_.size; }
  VkDeviceSize alignment() const { return alignment_; }  // of offset 0
  VkDeviceMemory memory() const { return allocation_.memory; }
  VkDeviceSize offset() const { return allocation_.offset; }  // in memory()

 private:
  Device& device_;
  uint32_t type_;
  VkDeviceSize alignment_;
  Allocation allocation_;
  std::unique_ptr<Deletion> deletion_;
};

}  // namespace latelight::vk
