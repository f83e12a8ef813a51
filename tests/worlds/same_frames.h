// Comparison of frames of worlds.
#pragma once

#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <cstring>

namespace latelight::test {

// The image and all data outputs of a frame are those of another one, to the byte.
inline void expectSameFrames(const Frame& actual, const Frame& expected) {
  EXPECT_EQ(actual.rgba, expected.rgba);
  for (const auto& [name, aov] : expected.aovs) {
    const Aov& other = actual.aovs.at(name);
    EXPECT_EQ(other.ids, aov.ids) << name;
    ASSERT_EQ(other.values.size(), aov.values.size()) << name;
    EXPECT_TRUE(aov.values.empty() ||
                std::memcmp(other.values.data(), aov.values.data(), aov.values.size() * sizeof(float)) == 0)
        << name;
  }
}

}  // namespace latelight::test
