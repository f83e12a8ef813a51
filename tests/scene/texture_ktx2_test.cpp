// KTX2 textures compared with files and texels of other programs, which ktx2/make.mjs lists.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "scene/textures/texture.h"

namespace latelight::scene {
namespace {

using testing::HasSubstr;
using Encoded = std::vector<std::byte>;

Encoded fileOf(const std::string& name) {
  return readFile(std::filesystem::path(LATELIGHT_SOURCE_DIR) / "tests/scene/ktx2" / name);
}

// The number of texels that differ from those of `expected`, and the maximum difference. Levels that `expected` lacks
// are not compared.
struct Difference {
  size_t texels = 0;
  int most = 0;
  bool operator==(const Difference&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Difference& d) {
  return out << d.texels << " texels by up to " << d.most;
}

Difference differenceOf(const std::string& file, bool srgb, const std::string& expectedFile) {
  const Texture texture = decodeTexture(fileOf(file), srgb, file);
  const Encoded expected = fileOf(expectedFile);
  EXPECT_LE(expected.size(), texture.bytes());
  Difference difference;
  for (size_t i = 0; i < expected.size(); i += 4) {
    int most = 0;
    for (size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(int(texture.pixels[i + c]) - int(expected[i + c])));
    difference.texels += most > 0;
    difference.most = std::max(difference.most, most);
  }
  return difference;
}

constexpr const char* kEtc1s[] = {"etc1s", "etc1s_alpha", "etc1s_one_level"};
constexpr const char* kUastc[] = {"uastc", "uastc_zstd", "uastc_modes"};

// Every level, as decoded by Basis Universal's own transcoder.
TEST(Ktx2, DecodesToTheBytesOfBasisUniversal) {
  for (const std::string name : kEtc1s)
    for (bool srgb : {false, true}) EXPECT_EQ(differenceOf(name + ".ktx2", srgb, name + ".rgba"), Difference{}) << name;
  for (const std::string name : kUastc)
    EXPECT_EQ(differenceOf(name + ".ktx2", false, name + ".rgba"), Difference{}) << name;
}

// sRGB colors are rounded in another way (Khronos Data Format 1.3, 23.19), as in Arm's ASTC decoder.
TEST(Ktx2, DecodesColorsAsAstcDoes) {
  for (const std::string name : kUastc)
    EXPECT_EQ(differenceOf(name + ".ktx2", true, name + "_srgb.rgba"), Difference{}) << name;
}

// Checks that an error names the texture; returns whether there was one.
bool isRefused(std::span<const std::byte> encoded) {
  try {
    decodeTexture(encoded, true, "images[7] (rust.ktx2)");
    return false;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::BadInput);
    EXPECT_THAT(error.what(), HasSubstr("images[7] (rust.ktx2)"));
    return true;
  }
}

// Flips each byte in turn, in header, index, codebooks and blocks.
TEST(Ktx2, SurvivesDamageToEachByte) {
  for (const std::string name : {"etc1s", "etc1s_one_level", "uastc", "uastc_zstd"}) {
    const Encoded whole = fileOf(name + ".ktx2");
    size_t refused = 0;
    for (size_t i = 0; i < whole.size(); ++i) {
      for (const uint8_t value :
           {uint8_t(0), uint8_t(0xff), uint8_t(uint8_t(whole[i]) ^ 1), uint8_t(uint8_t(whole[i]) ^ 0x80)}) {
        Encoded damaged = whole;
        damaged[i] = std::byte(value);
        // The size may become any valid one. A scene's memory limit would allow a GiB for each, but not a test.
        if (i >= 20 && i < 28) continue;
        refused += isRefused(damaged);
      }
    }
    EXPECT_GT(refused, 0u) << name;
  }
}

TEST(Ktx2, RefusesFilesThatEndEarly) {
  for (const std::string name : {"etc1s", "uastc_zstd"}) {
    const Encoded whole = fileOf(name + ".ktx2");
    // Levels are stored from the smallest to the largest, so the largest one ends at the end of the file.
    for (size_t bytes = 0; bytes < whole.size(); ++bytes)
      EXPECT_TRUE(isRefused(std::span(whole).first(bytes))) << bytes;
  }
}

// Valid KTX2 files that glTF does not allow.
TEST(Ktx2, RefusesOtherKindsOfTextures) {
  struct Case {
    size_t at;
    uint8_t value;
    const char* says;
  };
  for (const Case& c : {Case{12, 37, "UASTC"},
                        {28, 2, "two-dimensional"},
                        {32, 2, "two-dimensional"},
                        {36, 6, "two-dimensional"},
                        {40, 9, "mip levels"},
                        {44, 1, "UASTC"},
                        {44, 3, "UASTC"}}) {
    Encoded file = fileOf("uastc.ktx2");
    file[c.at] = std::byte(c.value);
    try {
      decodeTexture(file, false, "it");
      ADD_FAILURE() << c.at;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(c.says));
    }
  }
}

// A file with part of the mip chain gets the same levels as other images.
TEST(Ktx2, MakesTheLevelsThatAFileLacks) {
  const Encoded whole = fileOf("uastc_zstd.ktx2");
  Encoded cut = whole;
  cut[40] = std::byte{2};
  const Texture own = decodeTexture(whole, true, "own"), made = decodeTexture(cut, true, "made");
  Texture expected = makeTexture({own.width, own.height}, true, "expected");
  std::memcpy(expected.pixels.get(), own.pixels.get(), size_t{4} * own.width * own.height);
  buildMips(expected);
  EXPECT_EQ(std::memcmp(made.pixels.get(), expected.pixels.get(), expected.bytes()), 0);
  EXPECT_NE(std::memcmp(made.pixels.get(), own.pixels.get(), own.bytes()), 0);
}

}  // namespace
}  // namespace latelight::scene
