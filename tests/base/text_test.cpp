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

TEST(Text, IsAbbreviatedBetweenWords) {
  EXPECT_EQ(abbreviated("a built-in scene", 16), "a built-in scene");
  EXPECT_EQ(abbreviated("a built-in scene", 15), "a built-in...");
  EXPECT_EQ(abbreviated("a built-in scene", 13), "a built-in...");
  EXPECT_EQ(abbreviated("a built-in scene", 12), "a...");
  const std::string word(100, 'x');
  EXPECT_EQ(abbreviated("a " + word, 50), "a " + std::string(45, 'x') + "...");
  EXPECT_EQ(abbreviated("漢漢漢", 8), "漢...");
  EXPECT_EQ(abbreviated("ab cd", 2), "ab");
}

}  // namespace
}  // namespace latelight
