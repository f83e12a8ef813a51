// Suballocation of device memory: selects a memory type, then a block with free space or a dedicated allocation.
#include "vk/memory.h"

#include <algorithm>
#include <bit>
#include <new>

#include "base/error.h"
#include "base/memory.h"
#include "vk/device.h"
#include "vk/texel_window.h"

namespace latelight::vk {

struct Allocator::Block {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  uint32_t type = 0;
  bool linear = false;
  bool dedicated = false;
  std::byte* mapped = nullptr;
  BlockRanges ranges{0};
  uint64_t allocations = 0;
  MemoryClaim claim;  // claim of host memory

  bool isShared(uint32_t ofType, bool isLinear) const { return !dedicated && type == ofType && linear == isLinear; }
};

namespace {

// Resources above this size have dedicated allocations, because the rest of the block would be wasted.
constexpr VkDeviceSize kLargestShared = Allocator::kBlockSize / 4;

// The first block in the host's memory. GPUs pin its pages one by one when they allocate it, and newer lavapipe keeps
// memory in a shared file, whose pages the kernel clears one by one as they are touched.
constexpr VkDeviceSize kFirstHostBlock = VkDeviceSize{1} << 20;

struct MemoryPreference {
  VkMemoryPropertyFlags needed, preferred;
};

MemoryPreference preferenceFor(MemoryKind kind, bool cpuDevice) {
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  switch (kind) {
    case MemoryKind::Upload:
      return {kHost, 0};
    case MemoryKind::Readback:
      return {kHost, VK_MEMORY_PROPERTY_HOST_CACHED_BIT};
    default:
      return {0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | (cpuDevice ? kHost : 0)};
  }
}

// Returns the first type with all required and the maximum number of preferred properties, because drivers list the
// faster ones first. Returns ~0u if there is none.
uint32_t findType(const VkPhysicalDeviceMemoryProperties& memory, uint32_t allowed, MemoryPreference preference) {
  uint32_t best = ~0u;
  int bestScore = -1;
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    const VkMemoryPropertyFlags flags = memory.memoryTypes[i].propertyFlags;
    if (!(allowed >> i & 1) || (flags & preference.needed) != preference.needed) continue;
    const int score = __builtin_popcount(flags & preference.preferred);
    if (score <= bestScore) continue;
    best = i;
    bestScore = score;
  }
  return best;
}

double mebibytes(VkDeviceSize bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

}  // namespace

Allocator::Allocator(Device& device) : device_(device), window_(TexelWindow::make(device)) {
  vkGetPhysicalDeviceMemoryProperties(device.physical(), &properties_);
}

Allocator::~Allocator() {
  for (const auto& block : blocks_) vkFreeMemory(device_.get(), block->memory, nullptr);
}

uint32_t Allocator::typeFor(const VkMemoryRequirements& needs, MemoryKind kind) const {
  const uint32_t type = findType(properties_, needs.memoryTypeBits, preferenceFor(kind, device_.isCpu()));
  if (type == ~0u)
    fail(ExitCode::Internal, "No memory type suits a resource (allowed types {:#x}).", needs.memoryTypeBits);
  return type;
}

Allocation Allocator::allocate(const VkMemoryRequirements& needs, MemoryKind kind, bool linear, Sharing sharing) {
  std::lock_guard lock(mutex_);
  if (sharing != Sharing::Window) return allocateShared(needs, kind, linear, sharing);
  if (window_)
    if (Allocation found = window_->take(needs); found.memory) return found;
  Allocation allocation = allocateShared(needs, kind, linear, Sharing::Blocks);
  allocation.outside = window_ != nullptr;
  if (allocation.outside) ++outside_;
  return allocation;
}

Allocation Allocator::allocateShared(const VkMemoryRequirements& needs, MemoryKind kind, bool linear, Sharing sharing) {
  const uint32_t type = typeFor(needs, kind);
  if (sharing == Sharing::Blocks && needs.size > kLargestShared) sharing = Sharing::Dedicated;
  if (sharing == Sharing::Blocks)
    for (const auto& block : blocks_)
      if (block->isShared(type, linear))
        if (Allocation found = take(*block, needs); found.memory) return found;
  Block& block =
      addBlock(sharing == Sharing::Blocks ? nextBlockSize(needs, type, linear) : needs.size, type, linear, sharing);
  return take(block, needs);
}

// Blocks in the host's memory double what there is of their kind, so that at most half of what is allocated is unused.
// GPUs allocate whole blocks of their own memory at no cost.
VkDeviceSize Allocator::nextBlockSize(const VkMemoryRequirements& needs, uint32_t type, bool linear) const {
  const bool onGpu = (properties_.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0;
  if (onGpu && !device_.isCpu()) return kBlockSize;
  VkDeviceSize sum = 0;
  for (const auto& block : blocks_)
    if (block->isShared(type, linear)) sum += block->size;
  return std::clamp(std::bit_ceil(std::max(sum, needs.size)), kFirstHostBlock, kBlockSize);
}

Allocation Allocator::take(Block& block, const VkMemoryRequirements& needs) {
  const uint64_t offset = block.ranges.allocate(needs.size, needs.alignment);
  if (offset == BlockRanges::kNone) return {};
  ++block.allocations;
  return {block.memory, offset, needs.size, block.mapped ? block.mapped + offset : nullptr, &block};
}

Allocator::Block& Allocator::addBlock(VkDeviceSize size, uint32_t type, bool linear, Sharing sharing) {
  auto block = std::make_unique<Block>();
  block->size = size;
  block->type = type;
  block->linear = linear;
  block->dedicated = sharing != Sharing::Blocks;
  block->ranges = BlockRanges(size);
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = linear ? VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT : 0;
  VkExportMemoryAllocateInfo exported{VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO};
  exported.handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  if (sharing == Sharing::Exported) flags.pNext = &exported;
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  info.allocationSize = size;
  info.memoryTypeIndex = type;
  const VkMemoryType& memoryType = properties_.memoryTypes[type];
  const VkMemoryHeap& heap = properties_.memoryHeaps[memoryType.heapIndex];
  // A CPU device's heap limits each allocation to 2 GiB but not their sum. The device grants more memory than the
  // machine has, and the process is killed when it touches that memory.
  if (device_.isCpu() || !(heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT))
    block->claim = MemoryClaim(size, fmt::format("what {} works on", device_.info().name));
  blocks_.reserve(blocks_.size() + 1);
  const VkResult result = size > heap.size ? VK_ERROR_OUT_OF_DEVICE_MEMORY
                                           : vkAllocateMemory(device_.get(), &info, nullptr, &block->memory);
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY) failFull(size, heap.size);
  VK_CHECK(result);
  if (memoryType.propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) {
    void** const mapped = reinterpret_cast<void**>(&block->mapped);
    const VkResult mapping = vkMapMemory(device_.get(), block->memory, 0, VK_WHOLE_SIZE, 0, mapped);
    // Otherwise, later allocations would take it for memory that the host does not access.
    if (mapping != VK_SUCCESS) vkFreeMemory(device_.get(), block->memory, nullptr);
    VK_CHECK(mapping);
  }
  blocks_.push_back(std::move(block));
  return *blocks_.back();
}

VkDeviceSize Allocator::reserved() const {
  VkDeviceSize sum = 0;
  for (const auto& block : blocks_) sum += block->size;
  return sum;
}

void Allocator::failFull(VkDeviceSize size, VkDeviceSize room) const {
  fail(ExitCode::OutOfMemory,
       "{} cannot allocate another {:.1f} MiB: it has {:.0f} MiB, of which {:.0f} MiB are in use; use a smaller image "
       "or scene.",
       device_.info().name, mebibytes(size), mebibytes(room), mebibytes(reserved()));
}

void Allocator::release(const Allocation& allocation) {
  std::lock_guard lock(mutex_);
  if (window_ && window_->holds(allocation)) return window_->release(allocation);
  if (allocation.outside) --outside_;
  Block& block = *static_cast<Block*>(allocation.block);
  block.ranges.release(allocation.offset);
  --block.allocations;
  if (block.allocations > 0) return;
  // One empty block of each kind is kept, so that a single resource that is repeatedly created and freed does not
  // allocate a block each time.
  const auto isSpare = [&](const auto& other) {
    return other.get() != &block && other->isShared(block.type, block.linear) && other->allocations == 0;
  };
  if (!block.dedicated && std::none_of(blocks_.begin(), blocks_.end(), isSpare)) return;
  vkFreeMemory(device_.get(), block.memory, nullptr);
  std::erase_if(blocks_, [&](const auto& other) { return other.get() == &block; });
}

Allocator::Statistics Allocator::statistics() const {
  std::lock_guard lock(mutex_);
  Statistics total;
  for (const auto& block : blocks_) {
    ++total.blocks;
    total.allocations += block->allocations;
    total.reservedBytes += block->size;
    total.usedBytes += block->size - block->ranges.freeBytes();
  }
  if (!window_) return total;
  total.allocations += window_->allocations();
  total.reservedBytes += window_->usedBytes();
  total.usedBytes += window_->usedBytes();
  return total;
}

Heap::Heap(Device& device, uint32_t type, VkDeviceSize size, VkDeviceSize alignment)
    : device_(device),
      type_(type),
      alignment_(alignment),
      allocation_(device.memory().allocate({size, alignment, 1u << type}, MemoryKind::Device, true,
                                           Allocator::Sharing::Blocks)) {
  try {
    deletion_ = makeDeletion([&memory = device.memory(), allocation = allocation_] { memory.release(allocation); });
  } catch (const std::bad_alloc&) {
    device.memory().release(allocation_);
    throw;
  }
}

Heap::~Heap() {
  device_.deferDeletion(std::move(deletion_));
}

}  // namespace latelight::vk
