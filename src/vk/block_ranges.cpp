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
    const uint64_t rest = bytes - padding - size;
    if (padding > 0)
      range->second = padding;
    else
      free_.erase(range);
    if (rest > 0) free_.emplace(offset + size, rest);
    used_.emplace(offset, size);
    return offset;
  }
  return kNone;
}

void BlockRanges::release(uint64_t offset) {
  const auto used = used_.find(offset);
  assert(used != used_.end());
  if (used == used_.end()) return;
  auto range = free_.emplace(offset, used->second).first;
  used_.erase(used);
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
