#include "scene/camera_selector.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace latelight::scene {
namespace {

std::vector<Camera> named(const std::vector<std::string>& names) {
  std::vector<Camera> cameras(names.size());
  for (size_t i = 0; i < names.size(); ++i) cameras[i].name = names[i];
  return cameras;
}

TEST(CameraSelector, IsANameOrAnIndex) {
  const std::vector<Camera> cameras = named({"plan", "", "eye"});
  EXPECT_EQ(findCamera(cameras, "eye"), 2u);
  EXPECT_EQ(findCamera(cameras, "1"), 1u);
  EXPECT_EQ(findCamera(cameras, "#1"), 1u);
  for (const char* selector : {"3", "#3", "-1", "#-1", "#", "# 1", "1 ", "Eye", "#eye", "99999999999999999999"})
    EXPECT_EQ(findCamera(cameras, selector), std::nullopt) << selector;
  EXPECT_EQ(cameraSelector(cameras, 0), "plan");
  EXPECT_EQ(cameraSelector(cameras, 1), "#1");
}

// A name takes precedence over an index.
TEST(CameraSelector, DistinguishesNamesThatAreNumbers) {
  const std::vector<Camera> cameras = named({"1", "2"});
  EXPECT_EQ(findCamera(cameras, "1"), 0u);
  EXPECT_EQ(findCamera(cameras, "0"), 0u);
  EXPECT_EQ(findCamera(cameras, "2"), 1u);
  EXPECT_EQ(findCamera(cameras, "#1"), 1u);
}

TEST(CameraSelector, SelectsEachCamera) {
  for (const auto& names :
       {std::vector<std::string>{"1", "2", "0"}, {"cam", "cam", "cam"}, {"", ""}, {"#1", "#0"}, {"#2", "#7", "#7"}}) {
    const std::vector<Camera> cameras = named(names);
    for (size_t i = 0; i < cameras.size(); ++i)
      EXPECT_EQ(findCamera(cameras, cameraSelector(cameras, i)), i) << names[i];
  }
}

}  // namespace
}  // namespace latelight::scene
