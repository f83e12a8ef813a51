#include "base/text.h"

#include <gtest/gtest.h>

namespace latelight {
namespace {

// Characters of one to four bytes: U+0061, U+00FC, U+6F22, U+1F600.
TEST(Text, IsCutBetweenCharacters) {
  const std::string_view text = "aü漢😀";
  ASSERT_EQ(text.size(), 10u);
  const std::string_view beginnings[] = {"", "a", "a", "aü", "aü", "aü", "aü漢", "aü漢", "aü漢", "aü漢", text, text};
  for (size_t size = 0; size < std::size(beginnings); ++size)
    EXPECT_EQ(utf8Beginning(text, size), beginnings[size]) << size;
}

}  // namespace
}  // namespace latelight
