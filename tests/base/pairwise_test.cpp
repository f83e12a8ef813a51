#include "pairwise.h"

#include <gtest/gtest.h>

namespace latelight::test {
namespace {

TEST(Pairwise, MeetsEveryValidPairInFewCombinations) {
  // Values of the second choice other than 0 require the first to be below 2.
  const auto valid = [](const Combination& c) { return c[0] < 2 || c[1] == 0; };
  const std::vector<size_t> counts{6, 5, 4, 3};
  const std::vector<Combination> all = combinations(counts, valid), chosen = pairwise(counts, valid);
  EXPECT_EQ(all.size(), (2 * 5 + 4) * 4 * 3u);
  std::set<ValuePair> wanted, met;
  for (const Combination& c : all)
    for (const ValuePair& pair : pairsOf(c)) wanted.insert(pair);
  for (const Combination& c : chosen) {
    EXPECT_TRUE(valid(c));
    for (const ValuePair& pair : pairsOf(c)) met.insert(pair);
  }
  EXPECT_EQ(met, wanted);
  EXPECT_GE(chosen.size(), 24u);  // 6 * 4 pairs of the two largest choices
  EXPECT_LE(chosen.size(), 36u);
}

}  // namespace
}  // namespace latelight::test
