// A range of the process's address space that holds the buffers of a CPU device, and which shaders can also read as one
// texel buffer. lavapipe executes a load by address lane by lane and word by word, but a texel fetch as one vector load
// per lane: a node of a BVH takes an eighth of the time (docs/experiments.md, "Loads as texels").
//
//   address of a buffer, a multiple of 16          sceneWordsAt() in render/glsl/words.glsl:
//   | multiple of kSize | offset in the window |   texelFetch(sceneTexels, offset / 16)
//
// The window starts at a multiple of its size, so shaders need nothing but an address. The system provides its pages
// when they are first written, and takes those of large buffers back when they are released.
#pragma once

#include <volk.h>

#include <cstddef>
#include <memory>

#include "base/memory.h"
#include "vk/memory.h"

namespace latelight::vk {

class TexelWindow {
 public:
  static constexpr VkDeviceSize kSize = VkDeviceSize{2} << 30;  // 2^27 texels of 16 bytes, the limit of lavapipe

  // Returns null if the device does not support it: it requires VK_EXT_external_memory_host, and device addresses that
  // are those of the process.
  static std::unique_ptr<TexelWindow> make(Device& device);
  ~TexelWindow();
  TexelWindow(const TexelWindow&) = delete;
  TexelWindow& operator=(const TexelWindow&) = delete;

  // Buffers in the window are created with this type of external memory.
  static constexpr VkExternalMemoryHandleTypeFlags kHandleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
  // Returns memory in the window, or none if the window has no space for it. Throws Error(OutOfMemory) if the memory
  // exceeds the limit of the process.
  Allocation take(const VkMemoryRequirements& needs);
  void release(const Allocation& allocation);
  bool holds(const Allocation& allocation) const { return allocation.block == this; }
  VkDeviceAddress address() const { return reinterpret_cast<uintptr_t>(begin_); }
  uint64_t allocations() const { return allocations_; }
  uint64_t usedBytes() const { return kSize - ranges_.freeBytes(); }

  VkDescriptorSetLayout layout() const { return layout_; }
  VkDescriptorSet set() const { return set_; }  // binding 0: the window as uvec4 texels

 private:
  explicit TexelWindow(Device& device) : device_(device) {}
  bool reserve();
  bool import();
  void describe();
  Device& device_;
  std::byte* begin_ = nullptr;
  uint32_t type_ = 0;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkBufferView view_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  BlockRanges ranges_{kSize};
  uint64_t allocations_ = 0;
  MemoryClaim claim_;
};

}  // namespace latelight::vk
