// The resolution of drafts on devices of known speed, in closed form.
#include "view/draft.h"

#include <gtest/gtest.h>

namespace latelight::view {
namespace {

// A device with these times per picture and per pixel.
struct Device {
  double picture, pixel;
  double seconds(const render::Settings& s) const { return picture + pixel * s.width * s.height; }
};

render::Settings wholePicture() {
  render::Settings s;
  s.width = 1280, s.height = 720;
  return s;
}

render::Settings settled(const Device& device, bool slow) {
  Draft draft(slow);
  for (int i = 0; i < 20; ++i) draft.took(device.seconds(draft.of(wholePicture())));
  return draft.of(wholePicture());
}

TEST(DraftTest, AFastDeviceMakesTheWholePicture) {
  for (const bool slow : {false, true}) {
    const render::Settings draft = settled({0.002, 1e-9}, slow);
    EXPECT_EQ(draft.width, 1280u);
    EXPECT_EQ(draft.shadows, wholePicture().shadows);
  }
}

TEST(DraftTest, TenPicturesASecondWithAsManyPixelsAsThatLeaves) {
  for (const double whole : {0.2, 0.5, 1.0, 3.0}) {
    const Device device{0.01, whole / (1280 * 720)};
    const render::Settings draft = settled(device, false);
    EXPECT_LT(device.seconds(draft), 0.1) << whole;
    EXPECT_GT(device.seconds(draft), 0.015) << whole;
    EXPECT_EQ(draft.shadows, wholePicture().shadows) << "pixels alone are enough";
  }
}

// Once the size has settled, it no longer changes.
TEST(DraftTest, NothingSwings) {
  for (const double whole : {0.1, 0.3, 0.7, 2.0}) {
    const Device device{0.02, whole / (1280 * 720)};
    Draft draft(true);
    for (int i = 0; i < 20; ++i) draft.took(device.seconds(draft.of(wholePicture())));
    const uint32_t width = draft.of(wholePicture()).width;
    for (int i = 0; i < 20; ++i) {
      EXPECT_FALSE(draft.took(device.seconds(draft.of(wholePicture())))) << whole;
      EXPECT_EQ(draft.of(wholePicture()).width, width) << whole;
    }
  }
}

TEST(DraftTest, WhereTrianglesCostTheTimeShadowsAreLeftOut) {
  const render::Settings draft = settled({0.3, 1e-9}, true);
  EXPECT_EQ(draft.shadows, render::ShadowFormat::None);
  EXPECT_EQ(draft.raster, render::Raster::Compute);
}

TEST(DraftTest, SuperSamplingWaitsForTheWholePicture) {
  render::Settings whole = wholePicture();
  whole.aa.superSampling = 8;
  EXPECT_EQ(Draft(true).of(whole).aa.superSampling, 1u);
  EXPECT_EQ(Draft(false).of(whole).aa.superSampling, 8u);
}

}  // namespace
}  // namespace latelight::view
