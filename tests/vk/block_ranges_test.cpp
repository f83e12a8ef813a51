// The allocation of ranges in a block of device memory, against a brute-force model.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "vk/memory.h"

namespace latelight::vk {
namespace {

// A model with one flag per byte, which is slow but obviously correct.
class Model {
 public:
  explicit Model(size_t size) : used_(size, false) {}

  // First fit, as BlockRanges specifies.
  uint64_t firstFit(uint64_t size, uint64_t alignment) const {
    for (uint64_t offset = 0; offset + size <= used_.size(); offset += alignment)
      if (std::none_of(used_.begin() + offset, used_.begin() + offset + size, [](bool used) { return used; }))
        return offset;
    return BlockRanges::kNone;
  }
  void set(uint64_t offset, uint64_t size, bool used) {
    std::fill(used_.begin() + offset, used_.begin() + offset + size, used);
  }
  uint64_t freeBytes() const { return std::count(used_.begin(), used_.end(), false); }
  uint64_t largestFree() const {
    uint64_t best = 0, run = 0;
    for (bool used : used_) best = std::max(best, run = used ? 0 : run + 1);
    return best;
  }

 private:
  std::vector<bool> used_;
};

TEST(BlockRanges, AgreesWithABruteForceModel) {
  constexpr uint64_t kSize = 1500;
  std::mt19937 random(20240607);
  for (int round = 0; round < 20; ++round) {
    BlockRanges ranges(kSize);
    Model model(kSize);
    std::map<uint64_t, uint64_t> live;
    for (int step = 0; step < 600; ++step) {
      if (live.empty() || random() % 5 < 3) {
        const uint64_t size = 1 + random() % (random() % 4 ? 40 : 300);
        const uint64_t alignment = uint64_t{1} << random() % 9;
        const uint64_t expected = model.firstFit(size, alignment);
        const uint64_t offset = ranges.allocate(size, alignment);
        ASSERT_EQ(offset, expected) << "size " << size << " alignment " << alignment << " step " << step;
        if (offset == BlockRanges::kNone) continue;
        model.set(offset, size, true);
        live[offset] = size;
      } else {
        const auto victim = std::next(live.begin(), random() % live.size());
        ranges.release(victim->first);
        model.set(victim->first, victim->second, false);
        live.erase(victim);
      }
      ASSERT_EQ(ranges.freeBytes(), model.freeBytes());
      ASSERT_EQ(ranges.largestFree(), model.largestFree());
      ASSERT_EQ(ranges.empty(), live.empty());
    }
    for (const auto& [offset, size] : live) ranges.release(offset);
    EXPECT_TRUE(ranges.empty());
    EXPECT_EQ(ranges.largestFree(), kSize);
  }
}

TEST(BlockRanges, MergesWithBothNeighbors) {
  BlockRanges ranges(300);
  const uint64_t a = ranges.allocate(100, 1), b = ranges.allocate(100, 1), c = ranges.allocate(100, 1);
  EXPECT_EQ(ranges.allocate(1, 1), BlockRanges::kNone);
  ranges.release(a);
  ranges.release(c);
  EXPECT_EQ(ranges.largestFree(), 100u);
  ranges.release(b);
  EXPECT_EQ(ranges.largestFree(), 300u);
  EXPECT_EQ(ranges.allocate(300, 256), 0u);
}

TEST(BlockRanges, PaddingStaysFree) {
  BlockRanges ranges(1024);
  EXPECT_EQ(ranges.allocate(1, 1), 0u);
  EXPECT_EQ(ranges.allocate(16, 256), 256u);
  EXPECT_EQ(ranges.allocate(200, 4), 4u) << "the gap before an aligned range";
  EXPECT_EQ(ranges.freeBytes(), 1024u - 1 - 16 - 200);
}

TEST(BlockRanges, FillsToTheLastByte) {
  BlockRanges ranges(64);
  EXPECT_EQ(ranges.allocate(65, 1), BlockRanges::kNone);
  EXPECT_EQ(ranges.allocate(64, 64), 0u);
  EXPECT_EQ(ranges.freeBytes(), 0u);
  ranges.release(0);
  EXPECT_EQ(ranges.allocate(64, 1), 0u);
}

TEST(BlockRanges, HugeSizesDoNotWrap) {
  BlockRanges ranges(4096);
  ranges.allocate(10, 1);
  EXPECT_EQ(ranges.allocate(~uint64_t{0}, 1), BlockRanges::kNone);
  EXPECT_EQ(ranges.allocate(~uint64_t{0} - 4, 4096), BlockRanges::kNone);
  EXPECT_EQ(ranges.allocate(1, uint64_t{1} << 62), BlockRanges::kNone);
}

TEST(BlockRanges, EmptyAllocationsHaveDifferentOffsets) {
  BlockRanges ranges(16);
  const uint64_t a = ranges.allocate(0, 1), b = ranges.allocate(0, 1);
  EXPECT_NE(a, b);
  ranges.release(a);
  ranges.release(b);
  EXPECT_TRUE(ranges.empty());
}

}  // namespace
}  // namespace latelight::vk
