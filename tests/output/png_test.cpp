#include "output/png.h"

#include "support.h"

namespace latelight::output {
namespace {

using testing::HasSubstr;

// 0 to 2^bits - 1.
double code(const ReadImage& image, size_t channel, size_t pixel) {
  const Channel& c = image.channels.at(channel);
  return std::round(c.values.at(pixel) * (c.type == ChannelType::Unorm8 ? 255 : 65535));
}

double unorm(double value, double levels) {
  return std::floor(std::clamp(value, 0.0, 1.0) * levels + 0.5);
}

// IEC 61966-2-1, in double precision.
double srgb(double linear) {
  linear = std::clamp(linear, 0.0, 1.0);
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// The stored value according to the table, recomputed in double precision; +-1 where rounding of floats may decide
// otherwise.
struct Expected {
  size_t channels;
  ChannelType type;
  std::function<double(const AovImage&, size_t pixel, size_t channel)> code;
};

double value(const AovImage& image, size_t pixel, size_t channel) {
  return image.values[pixel * info(image.aov).channels + channel];
}

Expected expectedOf(Aov aov) {
  switch (info(aov).png) {
    case PngCoding::Display:
      return {4, ChannelType::Unorm8, [](const AovImage& i, size_t p, size_t c) {
                const double alpha = value(i, p, 3);
                if (c == 3) return unorm(alpha, 255);
                return alpha > 0 ? unorm(srgb(value(i, p, c) / alpha), 255) : 0.0;
              }};
    case PngCoding::Srgb:
      return {3, ChannelType::Unorm8,
              [](const AovImage& i, size_t p, size_t c) { return unorm(srgb(value(i, p, c)), 255); }};
    case PngCoding::Unit:
      return {info(aov).channels, ChannelType::Unorm16,
              [](const AovImage& i, size_t p, size_t c) { return unorm(value(i, p, c), 65535); }};
    case PngCoding::Signed:
      return {3, ChannelType::Unorm16, [](const AovImage& i, size_t p, size_t c) {
                const bool background = value(i, p, 0) == 0 && value(i, p, 1) == 0 && value(i, p, 2) == 0;
                return background ? 0.0 : unorm(value(i, p, c) * 0.5 + 0.5, 65535);
              }};
    case PngCoding::Millimetre:
      return {1, ChannelType::Unorm16, [](const AovImage& i, size_t p, size_t) {
                const double meters = value(i, p, 0);
                return std::isinf(meters) ? 0 : std::clamp(std::floor(meters * 1000 + 0.5), 1.0, 65535.0);
              }};
    case PngCoding::Fraction:
      return {3, ChannelType::Unorm16, [](const AovImage& i, size_t p, size_t c) {
                return c == 2 ? 0 : unorm(value(i, p, c) - std::floor(value(i, p, c)), 65535);
              }};
    case PngCoding::Count:
      return {1, ChannelType::Unorm16,
              [](const AovImage& i, size_t p, size_t) { return std::floor(value(i, p, 0) + 0.5); }};
    default:
      return {4, ChannelType::Unorm8,
              [](const AovImage& i, size_t p, size_t c) { return double((i.ids[p] >> (8 * c)) & 255); }};
  }
}

class EveryPng : public testing::TestWithParam<Aov> {};

TEST_P(EveryPng, HoldsWhatTheTableSays) {
  const AovImage image = numbers(GetParam(), 61, 37);
  const ReadImage back = decodePng(encodePng(image), "x.png");
  const Expected expected = expectedOf(GetParam());
  ASSERT_EQ(back.width, 61u);
  ASSERT_EQ(back.height, 37u);
  ASSERT_EQ(back.channels.size(), expected.channels);
  size_t rounded = 0;
  for (size_t c = 0; c < expected.channels; ++c) {
    ASSERT_EQ(back.channels[c].type, expected.type);
    for (size_t p = 0; p < 61 * 37; ++p) {
      const double want = expected.code(image, p, c), got = code(back, c, p);
      ASSERT_LE(std::abs(want - got), 1) << "pixel " << p << " channel " << c;
      rounded += want != got ? 1 : 0;
    }
  }
  const PngCoding coding = info(GetParam()).png;
  const bool exact = coding == PngCoding::IdBytes || coding == PngCoding::Count || coding == PngCoding::Millimetre;
  EXPECT_LE(rounded, exact ? 0u : 61 * 37 * expected.channels / 100);
}

std::vector<Aov> aovsWithPng() {
  std::vector<Aov> list;
  for (const AovInfo& aov : aovs())
    if (aov.png != PngCoding::None) list.push_back(aov.aov);
  return list;
}
INSTANTIATE_TEST_SUITE_P(Aovs, EveryPng, testing::ValuesIn(aovsWithPng()), [](const auto& param) {
  std::string name(latelight::output::info(param.param).name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Png, SaturatesDepthAndKeepsItApartFromBackground) {
  AovImage depth = makeAovImage(Aov::Depth, 6, 1);
  depth.values = {std::numeric_limits<float>::infinity(), 1e-6f, 1.2345f, 65.534f, 65.536f, 1e6f};
  const ReadImage back = decodePng(encodePng(depth), "x.png");
  const double expected[] = {0, 1, 1235, 65534, 65535, 65535};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(code(back, 0, i), expected[i]) << i;
}

TEST(Png, ClampsToTheUnitInterval) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float values[] = {std::nanf(""), -infinity, -0.5f, 0, 0.25f, 1, 1.5f, infinity};
  const double expected[] = {0, 0, 0, 0, 16384, 65535, 65535, 65535};
  AovImage ao = makeAovImage(Aov::Ao, 21, 1);  // not a multiple of the values that are converted at a time
  for (size_t i = 0; i < 21; ++i) ao.values[i] = values[i % 8];
  const ReadImage back = decodePng(encodePng(ao), "x.png");
  for (size_t i = 0; i < 21; ++i) EXPECT_EQ(code(back, 0, i), expected[i % 8]) << i;
}

TEST(Png, SurvivesNumbersThatAreNone) {
  for (const Aov aov : aovsWithPng()) {
    AovImage image = makeAovImage(aov, 4, 4);
    for (size_t i = 0; i < image.values.size(); ++i) {
      const float odd[] = {std::nanf(""), -std::numeric_limits<float>::infinity(), -1e30f, 1e30f};
      image.values[i] = odd[i % 4];
    }
    EXPECT_EQ(decodePng(encodePng(image), "x.png").width, 4u) << info(aov).name;
  }
}

// Every number of channels and bits, with pictures of one pixel, one row and many stripes.
TEST(Png, ComesBackExactlyInEveryShape) {
  std::mt19937 random(3);
  const std::pair<uint32_t, uint32_t> sizes[] = {{1, 1}, {300, 1}, {1, 300}, {517, 701}};
  for (const auto& [width, height] : sizes) {
    for (const uint32_t channels : {1u, 2u, 3u, 4u}) {
      for (const uint32_t bits : {8u, 16u}) {
        std::vector<uint16_t> pixels(size_t{width} * height * channels * bits / 16 + 1);
        for (uint16_t& p : pixels) p = static_cast<uint16_t>(random() & random());
        const auto* bytes = reinterpret_cast<const std::byte*>(pixels.data());
        const ReadImage back = decodePng(encodePng(width, height, channels, bits, bytes, PngLight::Data), "x.png");
        ASSERT_EQ(back.channels.size(), channels);
        size_t wrong = 0;
        for (size_t i = 0; i < size_t{width} * height * channels; ++i) {
          const double stored = bits == 16 ? pixels[i] : static_cast<double>(bytes[i]);
          wrong += code(back, i % channels, i / channels) != stored ? 1 : 0;
        }
        EXPECT_EQ(wrong, 0u) << width << "x" << height << " " << channels << " channels " << bits << " bits";
      }
    }
  }
}

bool contains(const std::vector<std::byte>& bytes, std::string_view text) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(text) !=
         std::string_view::npos;
}

TEST(Png, SaysWhetherItIsSrgb) {
  EXPECT_TRUE(contains(encodePng(numbers(Aov::Color, 4, 4)), "sRGB"));
  EXPECT_FALSE(contains(encodePng(numbers(Aov::Depth, 4, 4)), "sRGB"));
}

TEST(Png, IsTheSameEveryTime) {
  const AovImage image = numbers(Aov::Albedo, 900, 700);
  const std::vector<std::byte> first = encodePng(image);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(encodePng(image), first);
}

}  // namespace
}  // namespace latelight::output
