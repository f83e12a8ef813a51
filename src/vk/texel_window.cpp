#include "vk/texel_window.h"

#include <sys/mman.h>

#include <algorithm>

#include "vk/device.h"

namespace latelight::vk {

namespace {

constexpr VkDeviceSize kTexelBytes = 16;
constexpr VkDeviceSize kPage = 4096;

// Memory of released buffers of this size goes back to the system. Smaller ones are soon used again.
constexpr VkDeviceSize kReturnedBytes = VkDeviceSize{1} << 20;

bool isSupported(const Device& device) {
  return device.hasCpuShaders() && device.has(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME) &&
         device.properties().limits.maxTexelBufferElements >= TexelWindow::kSize / kTexelBytes &&
         device.maxBufferSize() >= TexelWindow::kSize && device.maxAllocationSize() >= TexelWindow::kSize;
}

// Returns the first type that the host sees without flushes, or ~0u.
uint32_t coherentType(const Device& device, uint32_t allowed) {
  constexpr VkMemoryPropertyFlags kNeeded =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device.physical(), &memory);
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & kNeeded) == kNeeded) return i;
  return ~0u;
}

}  // namespace

std::unique_ptr<TexelWindow> TexelWindow::make(Device& device) {
  if (!isSupported(device)) return nullptr;
  std::unique_ptr<TexelWindow> window(new TexelWindow(device));
  if (!window->reserve() || !window->import()) return nullptr;
  window->describe();
  window->ranges_.allocate(kPage, kPage);  // stays zero: lanes that have no address yet load from here
  return window;
}

// Reserves twice the address space, which contains a multiple of the size, and returns the rest. Under a limit of the
// process ("ulimit -v"), addresses that are only reserved would be missing elsewhere.
bool TexelWindow::reserve() {
  if (addressesLeft() < 8 * kSize) return false;
  constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
  void* const all = mmap(nullptr, 2 * kSize, PROT_READ | PROT_WRITE, kFlags, -1, 0);
  if (all == MAP_FAILED) return false;
  auto* const first = static_cast<std::byte*>(all);
  const VkDeviceSize before = (kSize - reinterpret_cast<uintptr_t>(all) % kSize) % kSize;
  begin_ = first + before;
  if (before > 0) munmap(first, before);
  munmap(begin_ + kSize, kSize - before);
  return true;
}

// Makes a buffer of the whole window. Returns false if its device address is not that of the process.
bool TexelWindow::import() {
  VkExternalMemoryBufferCreateInfo external{VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO};
  external.handleTypes = kHandleType;
  VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, &external};
  create.size = kSize;
  create.usage = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  if (vkCreateBuffer(device_.get(), &create, nullptr, &buffer_) != VK_SUCCESS) return false;
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_.get(), buffer_, &needs);
  const auto properties = reinterpret_cast<PFN_vkGetMemoryHostPointerPropertiesEXT>(
      vkGetDeviceProcAddr(device_.get(), "vkGetMemoryHostPointerPropertiesEXT"));
  VkMemoryHostPointerPropertiesEXT host{VK_STRUCTURE_TYPE_MEMORY_HOST_POINTER_PROPERTIES_EXT};
  if (properties(device_.get(), static_cast<VkExternalMemoryHandleTypeFlagBits>(kHandleType), begin_, &host) !=
      VK_SUCCESS)
    return false;
  type_ = coherentType(device_, needs.memoryTypeBits & host.memoryTypeBits);
  if (type_ == ~0u || needs.size > kSize) return false;
  VkImportMemoryHostPointerInfoEXT pointer{VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT};
  pointer.handleType = static_cast<VkExternalMemoryHandleTypeFlagBits>(kHandleType);
  pointer.pHostPointer = begin_;
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, &pointer};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  allocate.allocationSize = kSize;
  allocate.memoryTypeIndex = type_;
  if (vkAllocateMemory(device_.get(), &allocate, nullptr, &memory_) != VK_SUCCESS ||
      vkBindBufferMemory(device_.get(), buffer_, memory_, 0) != VK_SUCCESS)
    return false;
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer_;
  return vkGetBufferDeviceAddress(device_.get(), &address) == reinterpret_cast<uintptr_t>(begin_);
}

// Makes the descriptor set.
void TexelWindow::describe() {
  VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  view.buffer = buffer_;
  view.format = VK_FORMAT_R32G32B32A32_UINT;
  view.range = VK_WHOLE_SIZE;
  VK_CHECK(vkCreateBufferView(device_.get(), &view, nullptr, &view_));
  constexpr VkDescriptorType kType = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  const VkDescriptorSetLayoutBinding binding{0, kType, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  layout.bindingCount = 1;
  layout.pBindings = &binding;
  VK_CHECK(vkCreateDescriptorSetLayout(device_.get(), &layout, nullptr, &layout_));
  const VkDescriptorPoolSize size{kType, 1};
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &pool, nullptr, &pool_));
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &layout_;
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &allocate, &set_));
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.descriptorCount = 1;
  write.descriptorType = kType;
  write.pTexelBufferView = &view_;
  vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
}

TexelWindow::~TexelWindow() {
  vkDestroyDescriptorPool(device_.get(), pool_, nullptr);
  vkDestroyDescriptorSetLayout(device_.get(), layout_, nullptr);
  vkDestroyBufferView(device_.get(), view_, nullptr);
  vkDestroyBuffer(device_.get(), buffer_, nullptr);
  vkFreeMemory(device_.get(), memory_, nullptr);
  if (begin_) munmap(begin_, kSize);
}

Allocation TexelWindow::take(const VkMemoryRequirements& needs) {
  if (!(needs.memoryTypeBits >> type_ & 1)) return {};
  const uint64_t offset = ranges_.allocate(needs.size, std::max(needs.alignment, kTexelBytes));
  if (offset == BlockRanges::kNone) return {};
  try {
    claim_.grow(needs.size, fmt::format("what {} works on", device_.info().name));
  } catch (...) {
    ranges_.release(offset);
    throw;
  }
  ++allocations_;
  return {memory_, offset, needs.size, begin_ + offset, this};
}

void TexelWindow::release(const Allocation& allocation) {
  const VkDeviceSize first = (allocation.offset + kPage - 1) / kPage * kPage;
  const VkDeviceSize end = (allocation.offset + allocation.size) / kPage * kPage;
  if (allocation.size >= kReturnedBytes) madvise(begin_ + first, end - first, MADV_DONTNEED);
  --allocations_;
  ranges_.release(allocation.offset);
  claim_.shrink(allocation.size);
}

}  // namespace latelight::vk
