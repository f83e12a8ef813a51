// Depth packed in four bytes, checked through the bytes.
#include "shared/depth_packing.h"
#include "long_tests.h"

#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <mutex>

#include "base/parallel.h"

namespace latelight::shared {
namespace {

constexpr uint32_t kOne = std::bit_cast<uint32_t>(1.0f);

// The value that an RGBA8 target returns.
float stored(float channel) {
  return static_cast<float>(static_cast<int>(channel * 255.0f + 0.5f)) / 255.0f;
}
vec4 stored(vec4 e) {
  return vec4(stored(e.x), stored(e.y), stored(e.z), stored(e.w));
}

// All 1,065,353,217 of them.
TEST(DepthPacking, ExactKeepsEveryFloatFromZeroToOne) {
  std::atomic<uint64_t> wrong = 0, count = 0;
  const size_t step = latelight::test::runsInFull() ? 1 : 17;
  parallelFor(size_t{kOne} / step + 1, size_t{1} << 22, [&](size_t begin, size_t end) {
    uint64_t bad = 0;
    for (size_t i = begin; i < end; ++i) {
      const size_t bits = i * step;
      const float depth = std::bit_cast<float>(static_cast<uint32_t>(bits));
      bad += std::bit_cast<uint32_t>(unpackDepth(stored(packDepth(depth)))) != bits;
    }
    wrong += bad;
    count += end - begin;
  });
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(count, uint64_t{kOne} / step + 1);
}

TEST(DepthPacking, ExactKeepsWhatLiesOutside) {
  for (const float x : {-0.0f, -1.5f, 3.25e20f, INFINITY, -INFINITY})
    EXPECT_EQ(floatBitsToUint(unpackDepth(stored(packDepth(x)))), floatBitsToUint(x));
}

TEST(DepthPacking, ClassicTurnsOneIntoZero) {
  EXPECT_EQ(unpackDepthClassic(stored(packDepthClassic(1.0f))), 0.0f);
  EXPECT_EQ(unpackDepth(stored(packDepth(1.0f))), 1.0f);
}

// A sum of four floats below 1 may be rounded to 2^-24.
TEST(DepthPacking, ClassicErrsByAFewRoundingsBelowOne) {
  double worst = 0;
  for (uint32_t bits = 0; bits < kOne; bits += 97) {
    const float depth = std::bit_cast<float>(bits);
    worst = std::max(worst, std::abs(double{unpackDepthClassic(stored(packDepthClassic(depth)))} - depth));
  }
  EXPECT_LE(worst, 1.8e-7);
  EXPECT_GE(worst, 1.0e-7);
  RecordProperty("worst", std::to_string(worst * 1e9));
}

}  // namespace
}  // namespace latelight::shared
