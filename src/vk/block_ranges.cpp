// First-fit allocation of offsets within one memory block.
#include <algorithm>
#include <cassert>
#include <iterator>

#include "vk/memory.h"

namespace latelight::vk {

BlockRanges::BlockRanges(uint64_t size) {
  if (size > 0) free_.emplace(0, size);
}

uint64_t BlockRanges::allocate(uint64_t size, uint64_t alignment) {
  assert(alignment > 0 && (alignment & (alignment - 1)) == 0);
  // Distinct allocations have distinct offsets, even empty ones.
  if (size == 0) size = 1;
  for (auto range = free_.begin(); range != free_.end(); ++range) {
    const auto [begin, bytes] = *range;
    const uint64_t offset = (begin + alignment - 1) & ~(alignment - 1);
    const uint64_t padding = offset - begin;
    // This form of the comparison avoids overflow of the sum.
    if (padding > bytes || size > bytes - padding) continue;
    use(range, offset, size);
    return offset;
  }
  return kNone;
}

// Removes the bytes at `offset` from a free range, which contains them. If memory runs out, nothing changes.
void BlockRanges::use(Ranges::iterator range, uint64_t offset, uint64_t size) {
  const auto [begin, bytes] = *range;
  const uint64_t padding = offset - begin, rest = bytes - padding - size;
  Ranges made{{offset, size}};
  if (padding > 0 && rest > 0) {
    free_.emplace(offset + size, rest);
  } else if (rest > 0) {
    Ranges::node_type node = free_.extract(range);
    node.key() = offset + size;
    node.mapped() = rest;
    free_.insert(std::move(node));
  } else if (padding == 0) {
    free_.erase(range);
  }
  if (padding > 0) range->second = padding;
  used_.merge(made);
}

// Allocates nothing: the range moves from one map to the other.
void BlockRanges::release(uint64_t offset) noexcept {
  Ranges::node_type used = used_.extract(offset);
  assert(!used.empty());
  if (used.empty()) return;
  auto range = free_.insert(std::move(used)).position;
  const auto next = std::next(range);
  if (next != free_.end() && range->first + range->second == next->first) {
    range->second += next->second;
    free_.erase(next);
  }
  if (range == free_.begin()) return;
  const auto previous = std::prev(range);
  if (previous->first + previous->second != range->first) return;
  previous->second += range->second;
  free_.erase(range);
}

bool BlockRanges::empty() const {
  return used_.empty();
}

uint64_t BlockRanges::freeBytes() const {
  uint64_t bytes = 0;
  for (const auto& range : free_) bytes += range.second;
  return bytes;
}

uint64_t BlockRanges::largestFree() const {
  uint64_t bytes = 0;
  for (const auto& range : free_) bytes = std::max(bytes, range.second);
  return bytes;
}

}  // namespace latelight::vk
