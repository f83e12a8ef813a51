// The generator compared with the known answers of its paper, and its samples with the required distributions.
#include "data/random.h"

#include <gtest/gtest.h>

#include <set>

namespace latelight::data {
namespace {

// From kat_vectors of the Random123 library, philox4x32-10.
TEST(RandomTest, GivesTheKnownAnswers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomTest, SeedNumberAndNameSayAll) {
  Random first(7, 8, "what"), again(7, 8, "what");
  std::set<uint32_t> different;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(first.bits(), again.bits());
  for (Random other : {Random(7, 8, "what"), Random(8, 8, "what"), Random(7, 9, "what"), Random(7, 8, "that"),
                       Random(7 + (uint64_t{1} << 32), 8, "what"), Random(7, 8 + (uint64_t{1} << 32), "what")})
    different.insert(other.bits());
  EXPECT_EQ(different.size(), 6u);
}

// Chi-square with 19 degrees of freedom exceeds 42.31 once in 600 times.
double chiSquare(const std::vector<uint32_t>& counts, double expected) {
  double sum = 0;
  for (const uint32_t count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

TEST(RandomTest, NumbersAreUniform) {
  Random random(1, 2, "uniform");
  std::vector<uint32_t> units(20), below(20);
  for (int i = 0; i < 200000; ++i) {
    const double unit = random.unit();
    ASSERT_TRUE(unit >= 0 && unit < 1);
    ++units[static_cast<size_t>(unit * 20)];
    ++below[random.below(20)];
  }
  EXPECT_LT(chiSquare(units, 10000), 42.31);
  EXPECT_LT(chiSquare(below, 10000), 42.31);
  // Three quarters of 2^32: a product without rejection would return every third number twice as often.
  std::vector<uint32_t> thirds(3);
  for (int i = 0; i < 30000; ++i) ++thirds[random.below(3u << 30) % 3];
  EXPECT_LT(chiSquare(thirds, 10000), 13.8);  // two degrees of freedom, once in 1000 times
}

TEST(RandomTest, ChoosesEachAsOften) {
  std::vector<uint32_t> chosen(20);
  for (uint64_t i = 0; i < 20000; ++i) {
    const std::vector<uint32_t> some = Random(3, i, "choose").choose(5, 20);
    EXPECT_EQ(std::set<uint32_t>(some.begin(), some.end()).size(), 5u);
    for (const uint32_t one : some) ++chosen[one];
  }
  EXPECT_LT(chiSquare(chosen, 5000), 42.31);
}

}  // namespace
}  // namespace latelight::data
