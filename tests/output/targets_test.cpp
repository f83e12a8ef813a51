#include "output/targets.h"

#include <array>

#include "support.h"

namespace latelight::output {
namespace {

using Rgb = std::array<int, 3>;

Rgb pixel(const Labelled& labelled, size_t i) {
  const uint8_t* p = &labelled.picture.rgba[4 * i];
  EXPECT_EQ(p[3], 255);
  return {p[0], p[1], p[2]};
}

constexpr float kNowhere = std::numeric_limits<float>::infinity();

// Four pixels, the last of which is background.
RawGbuffer gbufferOf(RawTarget target) {
  return {.width = 4, .height = 1, .targets = {std::move(target)}, .depth = {1, 2, 3, kNowhere}};
}

RawTarget floats(const char* channels, TargetKind kind, uint32_t count, std::vector<float> values) {
  values.resize(16);
  return {.name = "target", .channels = channels, .kind = kind, .count = count, .values = std::move(values)};
}

TEST(TargetPictures, ShowColourAndAlphaApartWithWhatTheyHold) {
  const auto pictures = targetPictures(gbufferOf(
      floats("rgb: colour; a: power / 255", TargetKind::Unorm, 4, {1, 0, 0.2f, 0.6f, 0, 1, 0, 1, 0, 0, 1, 0})));
  ASSERT_EQ(pictures.size(), 3u);
  EXPECT_EQ(pictures[0].label, "target.rgb colour");
  EXPECT_EQ(pixel(pictures[0], 0), (Rgb{255, 0, 51}));
  EXPECT_EQ(pictures[1].label, "target.a power / 255");
  EXPECT_EQ(pixel(pictures[1], 0), (Rgb{153, 153, 153}));
  EXPECT_EQ(pictures[2].label, "depth");
  EXPECT_EQ(pixel(pictures[0], 3), pixel(pictures[2], 3));  // background
  EXPECT_EQ(pixel(pictures[1], 3), pixel(pictures[2], 3));
  EXPECT_NE(pixel(pictures[2], 0), pixel(pictures[2], 2));
}

TEST(TargetPictures, LeaveOutWhatIsUnusedOrNotThere) {
  EXPECT_EQ(targetPictures(gbufferOf(floats("rgb: normal; a: unused", TargetKind::Unorm, 4, {}))).size(), 2u);
  const auto two = targetPictures(gbufferOf(floats("rg: normal", TargetKind::Unorm, 2, {0.2f, 0.4f, 0.9f, 0.9f})));
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].label, "target.rg normal");
  EXPECT_EQ(pixel(two[0], 0), (Rgb{51, 102, 0}));
}

TEST(TargetPictures, ShowStoredCodesOfSrgbFormats) {
  const auto pictures =
      targetPictures(gbufferOf(floats("rgb: colour; a: ao", TargetKind::Srgb, 4, {0.21586f, 0, 1, 0.5f})));
  EXPECT_EQ(pixel(pictures[0], 0), (Rgb{128, 0, 255}));
  EXPECT_EQ(pixel(pictures[1], 0), (Rgb{128, 128, 128}));
}

TEST(TargetPictures, ScaleFloatsByTheirRangeAndSaySo) {
  const auto shown = [](std::vector<float> values) {
    return targetPictures(gbufferOf(floats("xyz: value; w: power", TargetKind::Float, 4, std::move(values))));
  };
  const auto direction = shown({-1, 0, 1, 0.25f});
  EXPECT_EQ(direction[0].label, "target.xyz value [x * 0.5 + 0.5]");
  EXPECT_EQ(pixel(direction[0], 0), (Rgb{0, 128, 255}));
  EXPECT_EQ(direction[1].label, "target.w power");
  EXPECT_EQ(pixel(direction[1], 0), (Rgb{64, 64, 64}));

  const auto position = shown({-10, 5, 0, 0, 10, 6, 0, 1, 0, 5.5f, 0, 1e6f});
  // the 99th percentile of three values is the second
  EXPECT_EQ(position[0].label, "target.xyz value [-10 to 0, 5 to 5.5, 0 to 0]");
  EXPECT_EQ(pixel(position[0], 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(pixel(position[0], 2), (Rgb{255, 255, 0}));

  EXPECT_EQ(pixel(shown({0.21586f, 0, 0, 0})[0], 0), (Rgb{128, 0, 0}));  // a colour
}

TEST(TargetPictures, StretchOverDecadesByLogarithms) {
  std::vector<float> values;
  for (const float power : {0.0f, 1e6f - 1, 999.0f, 0.0f}) values.insert(values.end(), {0, 0, 0, power});
  RawGbuffer gbuffer = gbufferOf(floats("rgb: colour; a: power", TargetKind::Float, 4, values));
  gbuffer.depth[3] = 4;
  gbuffer.width = 4;
  // Percentiles of four values: the smallest and the second largest.
  EXPECT_EQ(targetPictures(gbuffer)[1].label, "target.a power [0 to 999]");
  gbuffer.targets[0].values[11] = 1e6f - 1;
  const auto pictures = targetPictures(gbuffer);
  EXPECT_EQ(pictures[1].label, "target.a power [0 to 1e+06, log scale]");
  EXPECT_EQ(pixel(pictures[1], 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(pixel(pictures[1], 1), (Rgb{255, 255, 255}));
}

TEST(TargetPictures, MakeSmallCodesVisible) {
  const auto pictures = targetPictures(gbufferOf(
      floats("rgb: x; a: id / 255", TargetKind::Unorm, 4, {0, 0, 0, 1 / 255.0f, 0, 0, 0, 3 / 255.0f, 0, 0, 0, 0})));
  EXPECT_EQ(pictures[1].label, "target.a id / 255 [white is 3 / 255]");
  EXPECT_EQ(pixel(pictures[1], 0), (Rgb{85, 85, 85}));
  EXPECT_EQ(pixel(pictures[1], 1), (Rgb{255, 255, 255}));
}

TEST(TargetPictures, ShowIdsAsDebugPicturesDoAndOtherWordsByTheirBytes) {
  RawTarget words{.name = "words", .channels = "r: id of the object; g: packed", .kind = TargetKind::Words, .count = 2};
  words.words = {7, 0x40302010, 0, 0, 8, 1, 0, 0, 9, 2, 0, 0, 0, 0, 0, 0};
  const auto pictures = targetPictures(gbufferOf(words));
  ASSERT_EQ(pictures.size(), 4u);
  AovImage ids = makeAovImage(Aov::Id, 4, 1);
  ids.ids = {7, 8, 9, 0};
  EXPECT_EQ(pictures[0].picture.rgba, debugPicture(ids).rgba);
  EXPECT_EQ(pictures[1].label, "words.g packed [bytes 0 to 2]");
  EXPECT_EQ(pixel(pictures[1], 0), (Rgb{0x10, 0x20, 0x30}));
  EXPECT_EQ(pixel(pictures[2], 0), (Rgb{0x40, 0x40, 0x40}));
}

}  // namespace
}  // namespace latelight::output
