#include "output/debug.h"

#include <set>

#include "output/debug_request.h"
#include "support.h"

namespace latelight::output {
namespace {

using Pixel = std::array<int, 4>;

Pixel pixel(const Picture& picture, uint32_t x, uint32_t y = 0) {
  const uint8_t* p = &picture.rgba[(size_t{y} * picture.width + x) * 4];
  return {p[0], p[1], p[2], p[3]};
}

Pixel background() {
  return pixel(debugPicture(makeAovImage(Aov::Id, 1, 1)), 0);
}

TEST(DebugPicture, OfAnyAovIsOpaqueAndOfItsSize) {
  for (const AovInfo& aov : aovs()) {
    const Picture picture = debugPicture(numbers(aov.aov, 31, 17));
    ASSERT_EQ(picture.width, 31u);
    ASSERT_EQ(picture.height, 17u);
    ASSERT_EQ(picture.rgba.size(), 31u * 17 * 4);
    std::set<Pixel> colors;
    for (uint32_t i = 0; i < 31 * 17; ++i) {
      colors.insert(pixel(picture, i % 31, i / 31));
      ASSERT_EQ(picture.rgba[4 * i + 3], 255) << aov.name;
    }
    EXPECT_GT(colors.size(), aov.aov == Aov::Samples ? 4u : aov.aov == Aov::RasterOverdraw ? 30u : 50u) << aov.name;
  }
}

TEST(DebugPicture, IsADarkNeutralWhereNothingIsDrawn) {
  AovImage ids = makeAovImage(Aov::Id, 2, 1);
  ids.ids[1] = 5;
  for (const AovInfo& aov : aovs()) {
    const AovImage image = makeAovImage(aov.aov, 2, 1);
    EXPECT_EQ(pixel(debugPicture(image, &ids), 0), background()) << aov.name;
  }
  EXPECT_EQ(pixel(debugPicture(makeAovImage(Aov::Albedo, 2, 1), &ids), 1), (Pixel{0, 0, 0, 255}));
}

TEST(DebugPicture, OfRasterClassesHasAColourEachDarkerAtAnAngle) {
  AovImage classes = makeAovImage(Aov::RasterClasses, 9, 1);
  for (size_t i = 1; i < 9; ++i) {
    classes.values[2 * i] = static_cast<float>((i + 1) / 2);
    classes.values[2 * i + 1] = i % 2 ? 1.0f : 0.1f;
  }
  const Picture picture = debugPicture(classes);
  EXPECT_EQ(pixel(picture, 0), background());
  EXPECT_EQ(pixel(picture, 1), (Pixel{0, 158, 115, 255}));
  EXPECT_EQ(pixel(picture, 3), (Pixel{240, 227, 66, 255}));
  EXPECT_EQ(pixel(picture, 5), (Pixel{214, 94, 0, 255}));
  EXPECT_EQ(pixel(picture, 7), (Pixel{204, 120, 166, 255}));
  for (uint32_t i = 1; i < 9; i += 2)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel(picture, i + 1)[c], 0.46 * pixel(picture, i)[c], 1);
}

TEST(DebugPicture, OfOverdrawIsBrighterTheMore) {
  AovImage overdraw = makeAovImage(Aov::RasterOverdraw, 41, 1);
  for (size_t i = 0; i < 41; ++i) overdraw.values[i] = static_cast<float>(i);
  const Picture picture = debugPicture(overdraw);
  EXPECT_EQ(pixel(picture, 0), background());
  const auto brightness = [&](uint32_t x) {
    const Pixel p = pixel(picture, x);
    return 0.30 * p[0] + 0.59 * p[1] + 0.11 * p[2];  // the weights that cubehelix is designed for
  };
  for (uint32_t x = 1; x < 31; ++x) EXPECT_GT(brightness(x + 1), brightness(x)) << x;
  const double step = brightness(3) - brightness(1);  // per doubling
  EXPECT_NEAR(brightness(7) - brightness(3), step, 3);
  EXPECT_NEAR(brightness(31) - brightness(15), step, 3);
  for (uint32_t x = 32; x < 41; ++x) EXPECT_EQ(pixel(picture, x), pixel(picture, 31));
}

TEST(DebugPicture, OfDepthIsBrighterTheNearer) {
  AovImage depth = makeAovImage(Aov::Depth, 101, 1);
  for (size_t i = 0; i < 100; ++i) depth.values[i] = 2 + 0.1f * static_cast<float>(i);
  const Picture picture = debugPicture(depth);
  const auto brightness = [&](uint32_t x) {
    const Pixel p = pixel(picture, x);
    return 0.30 * p[0] + 0.59 * p[1] + 0.11 * p[2];  // the weights that cubehelix is designed for
  };
  for (uint32_t x = 2; x < 98; ++x) EXPECT_LT(brightness(x + 1), brightness(x) + 0.7) << x;
  EXPECT_GT(brightness(0), brightness(99) + 120);
  EXPECT_EQ(pixel(picture, 100), background());
}

TEST(DebugPicture, OfDepthSurvivesOneDepthAndNone) {
  AovImage depth = makeAovImage(Aov::Depth, 2, 1);
  EXPECT_EQ(pixel(debugPicture(depth), 1), background());
  depth.values[1] = 3;
  EXPECT_NE(pixel(debugPicture(depth), 1), background());
}

TEST(DebugPicture, OfIdsTellsNeighboursApart) {
  for (const Aov aov : {Aov::Id, Aov::Part, Aov::Material}) {
    AovImage ids = makeAovImage(aov, 64, 1);
    for (uint32_t i = 0; i < 64; ++i) ids.ids[i] = i;
    const Picture picture = debugPicture(ids);
    EXPECT_EQ(pixel(picture, 0), background());
    for (uint32_t i = 0; i + 1 < 64; ++i) {
      const Pixel a = pixel(picture, i), b = pixel(picture, i + 1);
      EXPECT_GT(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]), 40) << i;
    }
  }
}

TEST(DebugPicture, OfNormalsIsTheUsualOne) {
  AovImage normal = makeAovImage(Aov::Normal, 1, 1);
  normal.values = {0, 0, 1};
  EXPECT_EQ(pixel(debugPicture(normal), 0), (Pixel{128, 128, 255, 255}));
}

Picture plain(uint32_t width, uint32_t height, Pixel color) {
  Picture picture{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i)
    for (const int channel : color) picture.rgba.push_back(static_cast<uint8_t>(channel));
  return picture;
}

size_t count(const Picture& picture, Pixel color) {
  size_t found = 0;
  for (uint32_t y = 0; y < picture.height; ++y)
    for (uint32_t x = 0; x < picture.width; ++x) found += pixel(picture, x, y) == color ? 1 : 0;
  return found;
}

TEST(ContactSheet, HoldsEveryPictureAtItsSize) {
  const std::vector<Labelled> pictures{{"one", plain(100, 50, {255, 0, 0, 255})},
                                       {"two", plain(200, 100, {0, 255, 0, 255})},
                                       {"three", plain(40, 30, {0, 0, 255, 255})}};
  const Picture sheet = contactSheet(pictures, 2, 100);
  EXPECT_EQ(sheet.rgba.size(), size_t{sheet.width} * sheet.height * 4);
  EXPECT_EQ(count(sheet, {255, 0, 0, 255}), 100u * 50);
  EXPECT_EQ(count(sheet, {0, 255, 0, 255}), 100u * 50);  // scaled down
  EXPECT_EQ(count(sheet, {0, 0, 255, 255}), 40u * 30);   // never scaled up
  EXPECT_LT(sheet.width, 2 * 100 + 50u);
  EXPECT_LT(sheet.height, 2 * (50 + 30) + 50u);
}

TEST(ContactSheet, WritesItsLabels) {
  const auto ink = [](const std::string& label) {
    const std::vector<Labelled> one{{label, plain(200, 10, {0, 0, 0, 255})}};
    return count(contactSheet(one), {236, 236, 232, 255});
  };
  EXPECT_EQ(ink(""), 0u);
  EXPECT_GT(ink("depth"), 100u);
  EXPECT_GT(ink("depth and more"), ink("depth"));
  EXPECT_GT(ink("n\xc3\xa4h\n"), ink("nh"));                         // non-ASCII bytes become question marks
  EXPECT_GT(ink(std::string(500, 'm')), ink(std::string(10, 'm')));  // truncated at the picture's width
}

TEST(ContactSheet, BreaksLongLabelsAtSpaces) {
  const auto height = [](const std::string& label) {
    return contactSheet(std::vector<Labelled>{{label, plain(200, 10, {0, 0, 0, 255})}}).height;
  };
  EXPECT_EQ(height("depth"), height(""));
  EXPECT_EQ(height(std::string(500, 'm')), height(""));  // no space at which to break
  EXPECT_GT(height("what is in each channel of this target"), height(""));
  EXPECT_EQ(height("mmmmmmmmmmmmmmmmmmmm mmmmmmmmmmmmmmmmmmmm mmmmmmmmmmmmmmmmmmmm") - height(""),
            2 * (height("mmmmmmmmmmmmmmmmmmmm mmmmmmmmmmmmmmmmmmmm") - height("")));
}

// Averages are computed in linear light: half black, half white is 188, not 128.
TEST(ContactSheet, ScalesInLinearLight) {
  Picture stripes{200, 4, {}};
  for (uint32_t i = 0; i < 200 * 4; ++i) {
    const uint8_t v = i % 2 ? 255 : 0;
    stripes.rgba.insert(stripes.rgba.end(), {v, v, v, 255});
  }
  EXPECT_EQ(count(contactSheet(std::vector<Labelled>{{"", stripes}}, 1, 100), {188, 188, 188, 255}), 100u * 2);
}

TEST(ContactSheet, LaysTransparencyOverItsPaper) {
  const Picture sheet = contactSheet(std::vector<Labelled>{{"", plain(8, 8, {255, 255, 255, 0})}});
  EXPECT_EQ(count(sheet, pixel(sheet, 0, 0)), size_t{sheet.width} * sheet.height);
}

// The help of --debug names the outputs that the sheet omits.
TEST(DebugRequest, SheetOmitsTheOutputsThatTheHelpNames) {
  std::set<std::string_view> omitted, atRest;
  const DebugRequest moving = parseDebug("sheet", true), still = parseDebug("sheet", false);
  for (const AovInfo& aov : aovs()) {
    if (!contains(moving.aovs, aov.aov) && !aov.name.starts_with("raster-")) omitted.insert(aov.name);
    if (contains(moving.aovs, aov.aov) && !contains(still.aovs, aov.aov)) atRest.insert(aov.name);
    EXPECT_FALSE(contains(moving.aovs, aov.aov) && aov.name.starts_with("raster-")) << aov.name;
  }
  EXPECT_EQ(omitted, (std::set<std::string_view>{"raw", "samples"}));
  EXPECT_EQ(atRest, std::set<std::string_view>{"motion"});
}

TEST(ContactSheet, OfNothingIsAnError) {
  EXPECT_THAT(errorOf([] { contactSheet({}); }), testing::HasSubstr("at least one"));
}

}  // namespace
}  // namespace latelight::output
