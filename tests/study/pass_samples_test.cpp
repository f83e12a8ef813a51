// Medians and spreads of repeated measurements.
#include "study/pass_samples.h"

#include <gtest/gtest.h>

namespace latelight::study {
namespace {

TEST(PassSamples, MediansAreTheMiddleOrTheMeanOfTheTwoMiddleSamples) {
  EXPECT_EQ(median({}), 0);
  EXPECT_EQ(median({5}), 5);
  EXPECT_EQ(median({3, 1}), 2);
  EXPECT_EQ(median({9, 1, 2}), 2);
  EXPECT_EQ(median({8, 1, 100, 4}), 6);
}

// The quartiles of 1 to 5 are 2 and 4, and those of 1 to 4 are 1.75 and 3.25.
TEST(PassSamples, SpreadsAreTheMiddleHalfInPercentOfTheMedian) {
  EXPECT_EQ(spread({}), 0);
  EXPECT_EQ(spread({7, 7, 7, 7}), 0);
  EXPECT_DOUBLE_EQ(spread({5, 4, 3, 2, 1}), 100 * 2.0 / 3);
  EXPECT_DOUBLE_EQ(spread({4, 1, 3, 2}), 100 * 1.5 / 2.5);
}

}  // namespace
}  // namespace latelight::study
