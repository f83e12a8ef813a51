#include "base/lowercase.h"

#include <gtest/gtest.h>

namespace latelight {
namespace {

// The letters A to Z are 0x41 to 0x5a, and their lower case is 0x20 higher.
TEST(Lowercase, ChangesLettersOfAsciiOnly) {
  for (int code = 0; code < 256; ++code) {
    const int expected = code >= 0x41 && code <= 0x5a ? code + 0x20 : code;
    EXPECT_EQ(static_cast<unsigned char>(lowercase(static_cast<char>(code))), expected) << code;
  }
  EXPECT_EQ(lowercase(std::string("WOOD_ÄÖ 7.Png")), "wood_ÄÖ 7.png");
}

TEST(Lowercase, IsAppliedToTheExtensionOfAFile) {
  EXPECT_EQ(lowercaseExtension("A.GLB"), ".glb");
  EXPECT_EQ(lowercaseExtension("FOLDER.D/Sky.Hdr"), ".hdr");
  EXPECT_EQ(lowercaseExtension("a.tar.GZ"), ".gz");
  EXPECT_EQ(lowercaseExtension("FOLDER.D/SKY"), "");
  EXPECT_EQ(lowercaseExtension(".PNG"), "");
}

}  // namespace
}  // namespace latelight
