#include "base/hash.h"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace latelight {
namespace {

// Test vectors from Noll's page, http://www.isthe.com/chongo/tech/comp/fnv/.
static_assert(hash32("") == 0x811c9dc5u);
static_assert(hash32("a") == 0xe40c292cu);
static_assert(hash32("foobar") == 0xbf9cf968u);

// From the sanity checks of xxHash: XXH3_64bits of an empty input with seed 0.
TEST(Hash64, IsXxh3) {
  EXPECT_EQ(hash64(nullptr, 0), 0x2d06800538d394c2u);
}

TEST(Hash64, DependsOnEveryByteAndOnTheSeed) {
  std::vector<unsigned char> data(1000, 7);
  const uint64_t before = hash64(data.data(), data.size());
  EXPECT_NE(before, hash64(data.data(), data.size(), 1));
  EXPECT_NE(before, hash64(data.data(), data.size() - 1));
  for (size_t i = 0; i < data.size(); ++i) {
    data[i] ^= 1;
    EXPECT_NE(before, hash64(data.data(), data.size())) << i;
    data[i] ^= 1;
  }
  EXPECT_EQ(before, hash64(data.data(), data.size()));
}

}  // namespace
}  // namespace latelight
