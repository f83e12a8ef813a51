#include "output/npy.h"

#include <bit>
#include <cstring>

#include "support.h"

namespace latelight::output {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string textOf(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::vector<std::byte> bytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// Parses the header byte by byte, as in NumPy's format description.
TEST(Npy, HasTheHeaderOfVersionOne) {
  AovImage image = makeAovImage(Aov::Position, 2, 1);
  image.values = {1, 2, 3, 4, 5, 6};
  const std::string text = textOf(encodeNpy(image));
  std::string expected("\x93NUMPY\x01\x00\x76\x00", 10);
  expected += "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }";
  expected.append(127 - expected.size(), ' ');
  expected += '\n';
  ASSERT_EQ(text.size(), 128 + 24u);
  EXPECT_EQ(text.substr(0, 128), expected);
  EXPECT_EQ(std::memcmp(text.data() + 128, image.values.data(), 24), 0);
}

TEST(Npy, LeavesOutTheChannelsOfOne) {
  EXPECT_THAT(textOf(encodeNpy(makeAovImage(Aov::Depth, 5, 3))),
              HasSubstr("'<f4', 'fortran_order': False, 'shape': (3, 5), }"));
  EXPECT_THAT(textOf(encodeNpy(makeAovImage(Aov::Id, 5, 3))),
              HasSubstr("'<u4', 'fortran_order': False, 'shape': (3, 5), }"));
}

TEST(Npy, HoldsEveryAovExactly) {
  for (const AovInfo& aov : aovs()) {
    const AovImage image = numbers(aov.aov, 13, 11);
    const ReadImage back = decodeNpy(encodeNpy(image), "x.npy");
    ASSERT_EQ(back.channels.size(), aov.channels) << aov.name;
    ASSERT_EQ(back.width, 13u);
    ASSERT_EQ(back.height, 11u);
    for (size_t p = 0; p < 13 * 11; ++p) {
      for (size_t c = 0; c < aov.channels; ++c) {
        const double want = image.ids.empty() ? image.values[p * aov.channels + c] : static_cast<double>(image.ids[p]);
        ASSERT_EQ(back.channels[c].values[p], want) << aov.name;
      }
    }
  }
}

std::vector<std::byte> array(std::string dictionary, std::string_view data) {
  dictionary.resize((dictionary.size() + 64) / 64 * 64, ' ');
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(dictionary.size());
  text += '\0';
  return bytesOf(text + dictionary + std::string(data));
}

TEST(Npy, OfOtherTypesIsRead) {
  const ReadImage bytes =
      decodeNpy(array("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2), }", "\x07\xff"), "x");
  EXPECT_EQ(bytes.channels[0].values, (std::vector<double>{7, 255}));
  const ReadImage wide = decodeNpy(
      array("{'shape': (1, 1,), 'fortran_order': False, 'descr': '<i2'}", std::string_view("\xfe\xff", 2)), "x");
  EXPECT_EQ(wide.channels[0].values, (std::vector<double>{-2}));
  const ReadImage half = decodeNpy(
      array("{'descr': '<f2', 'fortran_order': False, 'shape': (1, 1, 1)}", std::string_view("\x00\x3e", 2)), "x");
  EXPECT_EQ(half.channels[0].values, (std::vector<double>{1.5}));
}

// A double represents every integer up to 2^53, but not 2^53 + 1, which rounds to 2^53.
TEST(Npy, RejectsIntegersThatDoublesRound) {
  const auto read = [](const char* type, uint64_t second) {
    const uint64_t values[] = {0, second};
    const std::vector<uint64_t> shape{2, 1};
    return decodeNpy(encodeNpy(type, shape, std::as_bytes(std::span(values))), "some/a.id.npy");
  };
  constexpr uint64_t kLimit = uint64_t{1} << 53;
  EXPECT_EQ(read("<u8", kLimit - 1).channels[0].values, (std::vector<double>{0, 9007199254740991}));
  EXPECT_EQ(read("<i8", 1 - kLimit).channels[0].values, (std::vector<double>{0, -9007199254740991}));
  EXPECT_EQ(read("<f8", std::bit_cast<uint64_t>(1e300)).channels[0].values, (std::vector<double>{0, 1e300}));
  for (const auto& number : {std::pair("<u8", kLimit + 1), std::pair("<i8", kLimit + 1), std::pair("<u8", ~uint64_t{0}),
                             std::pair("<i8", uint64_t{1} << 63)}) {
    EXPECT_THAT(errorOf([&] { read(number.first, number.second); }, ExitCode::BadInput),
                AllOf(HasSubstr("some/a.id.npy"), HasSubstr("pixel 0,1"), HasSubstr("below 2^53")))
        << number.first << " " << number.second;
  }
}

TEST(Npy, ThatIsNoPictureIsRefusedByWhatIsWrong) {
  const auto says = [](const std::vector<std::byte>& bytes) {
    return errorOf([&] { decodeNpy(bytes, "some/a.npy"); }, ExitCode::BadInput);
  };
  const std::pair<const char*, const char*> cases[] = {
      {"{'descr': '>f4', 'fortran_order': False, 'shape': (1, 1), }", "'>f4'"},
      {"{'descr': '<f4', 'fortran_order': True, 'shape': (1, 1), }", "Fortran"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (4,), }", "1 dimensions"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }", "before its last value"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (0, 2), }", "empty"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999, 99999999999), }", "larger"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999, 1), }", "shape"},
      {"{'descr': [('r', '<f4')], 'fortran_order': False, 'shape': (1, 1), }", "simple"},
      {"{'descr': '<f4', 'shape': (1, 1), }", "fortran_order"},
  };
  for (const auto& [dictionary, why] : cases) {
    EXPECT_THAT(says(array(dictionary, "abcd")), AllOf(HasSubstr("some/a.npy"), HasSubstr(why))) << dictionary;
  }
}

}  // namespace
}  // namespace latelight::output
