// Comparison of frames of worlds.
#pragma once

#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace latelight::test {

// How many elements differ, and by how much, if the bytes of two arrays do.
template <typename T>
testing::AssertionResult haveSameBytes(const std::vector<T>& actual, const std::vector<T>& expected) {
  if (actual.size() != expected.size())
    return testing::AssertionFailure() << actual.size() << " elements instead of " << expected.size();
  if (expected.empty() || std::memcmp(actual.data(), expected.data(), expected.size() * sizeof(T)) == 0)
    return testing::AssertionSuccess();
  size_t count = 0;
  double largest = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (std::memcmp(&actual[i], &expected[i], sizeof(T)) == 0) continue;
    ++count;
    largest = std::max(largest, std::abs(double(actual[i]) - double(expected[i])));
  }
  return testing::AssertionFailure() << count << " of " << expected.size() << " elements differ, by up to " << largest;
}

// The image and all data outputs of a frame are those of another one, to the byte.
inline void expectSameFrames(const Frame& actual, const Frame& expected) {
  EXPECT_TRUE(haveSameBytes(actual.rgba, expected.rgba));
  for (const auto& [name, aov] : expected.aovs) {
    const Aov& other = actual.aovs.at(name);
    EXPECT_TRUE(haveSameBytes(other.ids, aov.ids)) << name;
    EXPECT_TRUE(haveSameBytes(other.values, aov.values)) << name;
  }
}

}  // namespace latelight::test
