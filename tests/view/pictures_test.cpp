// Splits, outlines and dragged objects, by known pixels.
#include <gtest/gtest.h>

#include "scene/file_frame.h"
#include "scene/framing.h"
#include "view/in_picture.h"
#include "view/outline.h"
#include "view/shell_words.h"
#include "view/split.h"

namespace latelight::view {
namespace {

output::Picture plain(uint32_t width, uint32_t height, uint8_t grey) {
  return {width, height, std::vector<uint8_t>(size_t{4} * width * height, grey)};
}

uint8_t redAt(const output::Picture& picture, uint32_t x, uint32_t y) {
  return picture.rgba[4 * (size_t{y} * picture.width + x)];
}

TEST(SplitTest, TheRightSideBeginsAtTheSlider) {
  const output::Picture picture = splitPicture(plain(10, 4, 10), plain(10, 4, 200), {SetSplit::Slider, 0.3});
  for (uint32_t x = 0; x < 10; ++x) EXPECT_EQ(redAt(picture, x, 2), x < 3 ? 10 : 200);
}

TEST(SplitTest, ASmallerRightSideIsScaled) {
  output::Picture right = plain(5, 2, 0);
  right.rgba[4 * (5 + 4)] = 77;  // the lower right pixel
  const output::Picture picture = splitPicture(plain(10, 4, 10), right, {SetSplit::Slider, 0});
  EXPECT_EQ(redAt(picture, 9, 3), 77);
  EXPECT_EQ(redAt(picture, 7, 3), 0);
  EXPECT_EQ(redAt(picture, 8, 1), 0);
}

TEST(SplitTest, DifferencesAreAmplifiedAndOpaque) {
  const SetSplit split{SetSplit::Difference, 0.5, 8};
  EXPECT_EQ(redAt(splitPicture(plain(4, 4, 100), plain(4, 4, 103), split), 1, 1), 24);
  EXPECT_EQ(redAt(splitPicture(plain(4, 4, 103), plain(4, 4, 100), split), 1, 1), 24);
  EXPECT_EQ(redAt(splitPicture(plain(4, 4, 0), plain(4, 4, 100), split), 1, 1), 255);
  EXPECT_EQ(splitPicture(plain(4, 4, 0), plain(4, 4, 0), split).rgba[3], 255);
}

TEST(OutlineTest, LiesJustOutside) {
  output::AovImage ids = output::makeAovImage(output::Aov::Id, 8, 8);
  for (const uint32_t y : {3u, 4u})
    for (const uint32_t x : {3u, 4u}) ids.ids[8 * y + x] = 42;
  output::Picture picture = plain(8, 8, 10);
  drawOutline(picture, ids, 42);
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t x = 0; x < 8; ++x) {
      const bool inside = x >= 3 && x <= 4 && y >= 3 && y <= 4, near = x >= 2 && x <= 5 && y >= 2 && y <= 5;
      EXPECT_EQ(redAt(picture, x, y), near && !inside ? 255 : 10) << x << "," << y;
    }
}

scene::Camera frontal() {
  scene::Scene empty;
  return scene::lookAt(empty, {0, 0, 5}, {0, 0, 0}, {}, 1.0f);
}

TEST(InPictureTest, PlacesByTheirTangents) {
  scene::Scene empty;
  const auto at = pixelOf(frontal(), {400, 200}, scene::worldFromFile(empty, {1, 0.5, 0}));
  ASSERT_TRUE(at);
  const double height = 2 * 5 * std::tan(0.5);
  EXPECT_NEAR(at->x, 200 + 200 / height, 1e-3);
  EXPECT_NEAR(at->y, 100 - 100 / height, 1e-3);
  EXPECT_FALSE(pixelOf(frontal(), {400, 200}, scene::worldFromFile(empty, {0, 0, 6}))) << "behind the camera";
}

TEST(InPictureTest, WhatIsDraggedIsWhereItWasDraggedTo) {
  scene::Scene empty;
  const glm::vec3 from = scene::worldFromFile(empty, {1, 0.5, -2});
  const auto to = draggedTo(frontal(), {400, 200}, from, {37, 150});
  ASSERT_TRUE(to);
  EXPECT_NEAR(to->y, from.y, 1e-4) << "at its own depth";
  const auto at = pixelOf(frontal(), {400, 200}, *to);
  EXPECT_NEAR(at->x, 37, 1e-2);
  EXPECT_NEAR(at->y, 150, 1e-2);
}

TEST(ShellWordsTest, AreQuotedWhereAShellWouldReadThem) {
  const std::vector<std::string> words{"render", "--fog-color=#bcbcbc", "--shadow-lights=it's", "a b.glb", ""};
  EXPECT_EQ(shellWords(words), "render '--fog-color=#bcbcbc' '--shadow-lights=it'\\''s' 'a b.glb' ''");
}

}  // namespace
}  // namespace latelight::view
