// Comparison of frames of worlds.
#pragma once

#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <vector>

namespace latelight::test {

// The largest difference, relative to values above 1, that rounding makes. 0 on Debian 12's lavapipe, where pictures of
// worlds have the bytes of the edited scene. Other drivers fuse products into sums in one of the two pictures' shaders
// only: LATELIGHT_TEST_ROUNDING is 1e-5 for these (docs/quality.md, "Other drivers").
inline double rounding() {
  const char* given = std::getenv("LATELIGHT_TEST_ROUNDING");
  return given ? std::atof(given) : 0;
}

// Where a result depends on which side of an edge or of a threshold a rounded value lies, one in a thousand values may
// differ by a hundred times as much.
constexpr double kFarther = 100;
constexpr size_t kFartherIn = 1000;

// How many elements differ, and by how much, if the bytes of two arrays do, beyond rounding().
template <typename T>
testing::AssertionResult haveSameBytes(const std::vector<T>& actual, const std::vector<T>& expected) {
  if (actual.size() != expected.size())
    return testing::AssertionFailure() << actual.size() << " elements instead of " << expected.size();
  if (expected.empty() || std::memcmp(actual.data(), expected.data(), expected.size() * sizeof(T)) == 0)
    return testing::AssertionSuccess();
  // Pixels of 8 bits may differ by one level, but seldom.
  constexpr bool isFloat = std::is_floating_point_v<T>;
  const double allowed = isFloat || rounding() == 0 ? rounding() : sizeof(T) == 1 ? 1 / kFarther : 0;
  size_t count = 0, beyond = 0;
  double largest = 0, farthest = 0;  // farthest: in units of what is allowed
  for (size_t i = 0; i < expected.size(); ++i) {
    if (std::memcmp(&actual[i], &expected[i], sizeof(T)) == 0) continue;
    ++count;
    const double difference = std::abs(double(actual[i]) - double(expected[i]));
    largest = std::max(largest, difference);
    const double units = difference / (allowed * (isFloat ? std::max(1.0, std::abs(double(expected[i]))) : 1.0));
    if (!(units <= 1)) ++beyond;
    farthest = units <= farthest ? farthest : units;
  }
  if (allowed > 0 && beyond * kFartherIn <= expected.size() && farthest <= kFarther) return testing::AssertionSuccess();
  return testing::AssertionFailure() << count << " of " << expected.size() << " elements differ, by up to " << largest;
}

// The image and all data outputs of a frame are those of another one, to the byte or to rounding().
inline void expectSameFrames(const Frame& actual, const Frame& expected) {
  EXPECT_TRUE(haveSameBytes(actual.rgba, expected.rgba));
  for (const auto& [name, aov] : expected.aovs) {
    const Aov& other = actual.aovs.at(name);
    EXPECT_TRUE(haveSameBytes(other.ids, aov.ids)) << name;
    EXPECT_TRUE(haveSameBytes(other.values, aov.values)) << name;
  }
}

}  // namespace latelight::test
