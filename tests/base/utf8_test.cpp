#include "base/utf8.h"

#include <gtest/gtest.h>

namespace latelight {
namespace {

TEST(Utf8, DecodesCharactersOfOneToFourBytes) {
  const auto expect = [](std::string_view text, uint32_t code, size_t bytes) {
    const Utf8Character character = firstUtf8Character(text);
    EXPECT_EQ(character.code, code) << text;
    EXPECT_EQ(character.bytes, bytes) << text;
  };
  expect("a!", 0x61, 1);
  expect("\xc3\xbc!", 0xfc, 2);
  expect("\xe6\xbc\xa2!", 0x6f22, 3);
  expect("\xf0\x9f\x98\x80!", 0x1f600, 4);
  // A continuation byte, a cut character, an overlong form, a surrogate, and a code above U+10FFFF.
  for (const std::string_view invalid : {"\x80", "\xe2\x82", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80"})
    expect(invalid, Utf8Character::kInvalid, 1);
}

TEST(Utf8, OtherTextIsLatin1) {
  EXPECT_EQ(utf8OrLatin1(""), "");
  EXPECT_EQ(utf8OrLatin1("aü漢😀"), "aü漢😀");
  EXPECT_EQ(utf8OrLatin1("Terrain\xe6k"), "Terrainæk");
  EXPECT_EQ(utf8OrLatin1("\x80\xbf\xc0\xff"), "\u0080\u00bf\u00c0\u00ff");
  EXPECT_EQ(utf8OrLatin1("\xc3\xbc \xfc"), "\u00c3\u00bc \u00fc") << "the whole text is Latin-1";
  EXPECT_TRUE(isUtf8("aü漢😀"));
  EXPECT_FALSE(isUtf8("Terrain\xe6k"));
}

}  // namespace
}  // namespace latelight
