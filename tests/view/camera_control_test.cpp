// Camera control compared with geometry: the positions of points in the picture before and after each movement.
#include "view/camera_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace latelight::view {
namespace {

using glm::dvec2;
using glm::dvec3;
constexpr double kPi = std::numbers::pi;

// In units of the picture's height from its center, y down, by similar triangles.
dvec2 projected(const Viewpoint& view, dvec3 point) {
  const dvec3 away = glm::normalize(view.target - view.eye);
  const dvec3 right = glm::normalize(glm::cross(away, dvec3(0, 0, 1))), up = glm::cross(right, away);
  const dvec3 way = point - view.eye;
  const double depth = glm::dot(way, away), height = 2 * std::tan(view.verticalFov / 2) * depth;
  return {glm::dot(way, right) / height, -glm::dot(way, up) / height};
}

// Scenes from the size of dust to that of countries.
class CameraControlTest : public testing::TestWithParam<double> {
 protected:
  double size() const { return GetParam(); }
  Viewpoint view() const { return {dvec3(0.3, -2, 0.7) * size(), dvec3(0.1, 0.2, 0.3) * size(), 0.8}; }
  CameraControl control() const { return {view(), size()}; }
  void expectNear(dvec2 a, dvec2 b) const {
    EXPECT_NEAR(a.x, b.x, 1e-9);
    EXPECT_NEAR(a.y, b.y, 1e-9);
  }
  double distance(const CameraControl& c) const { return glm::length(c.view().eye - c.view().target); }
};

TEST_P(CameraControlTest, BeginsWhereItIsPut) {
  EXPECT_LT(glm::length(control().view().eye - view().eye), 1e-12 * size());
  EXPECT_EQ(control().view().target, view().target);
}

TEST_P(CameraControlTest, RaysGoThroughWhatIsSeenThere) {
  for (const dvec2 place : {dvec2(0, 0), dvec2(0.5, -0.3), dvec2(-0.8, 0.5)})
    expectNear(projected(view(), view().eye + rayThrough(view(), place) * (3 * size())), place);
}

TEST_P(CameraControlTest, AnOrbitOfAHeightIsHalfATurn) {
  CameraControl c = control();
  const double before = distance(c);
  c.orbit({1, 0});
  const dvec3 from = view().eye - view().target, to = c.view().eye - c.view().target;
  EXPECT_NEAR(to.x, -from.x, 1e-9 * size());
  EXPECT_NEAR(to.y, -from.y, 1e-9 * size());
  EXPECT_NEAR(to.z, from.z, 1e-9 * size());
  EXPECT_NEAR(distance(c), before, 1e-9 * size());
}

TEST_P(CameraControlTest, WhatIsInFrontFollowsAnOrbit) {
  CameraControl c = control();
  const dvec3 front = view().target + glm::normalize(view().eye - view().target) * (0.2 * size());
  c.orbit({0.05, 0.02});
  EXPECT_GT(projected(c.view(), front).x, 0.001);
  EXPECT_GT(projected(c.view(), front).y, 0.001);
}

TEST_P(CameraControlTest, NoOrbitGoesOverThePoles) {
  CameraControl c = control();
  for (const double drag : {5.0, -9.0}) {
    c.orbit({0, drag});
    const dvec3 up = axesOf(c.view()).up;
    EXPECT_GT(up.z, 0);
    EXPECT_NEAR(glm::length(up), 1, 1e-12);
  }
}

TEST_P(CameraControlTest, WhatIsPannedFollowsThePointer) {
  for (const dvec2 drag : {dvec2(0.25, 0), dvec2(0, 0.25), dvec2(-0.4, 0.1)}) {
    CameraControl c = control();
    const dvec3 shown = view().eye + rayThrough(view(), {0.1, 0.2}) * distance(c);  // in the target's plane
    c.pan(drag);
    expectNear(projected(c.view(), shown), dvec2(0.1, 0.2) + drag);
  }
}

TEST_P(CameraControlTest, APointThatIsApproachedStaysInPlace) {
  CameraControl c = control();
  const dvec3 point = view().eye + rayThrough(view(), {0.4, -0.3}) * (1.5 * size());
  const double before = glm::length(point - view().eye);
  c.dolly(3, point);
  expectNear(projected(c.view(), point), {0.4, -0.3});
  EXPECT_NEAR(glm::length(point - c.view().eye), before * 0.9 * 0.9 * 0.9, 1e-9 * size());
  c.dolly(-3, point);
  EXPECT_LT(glm::length(c.view().eye - view().eye), 1e-9 * size());
}

TEST_P(CameraControlTest, NothingEverMeetsItsTarget) {
  CameraControl c = control();
  for (int i = 0; i < 1000; ++i) c.dolly(20, c.view().target);
  EXPECT_GT(distance(c), 0);
  EXPECT_LT(distance(c), 1e-5 * size());
}

TEST_P(CameraControlTest, LooksWhereThePointerGoes) {
  CameraControl c = control();
  c.look({0.1, 0});
  EXPECT_LT(glm::length(c.view().eye - view().eye), 1e-12 * size());
  EXPECT_LT(projected(c.view(), view().target).x, -0.05) << "to the right: what was in the middle is left of it";
  c = control();
  c.look({0, 0.1});
  EXPECT_LT(projected(c.view(), view().target).y, -0.05);
}

TEST_P(CameraControlTest, FliesAtItsSpeed) {
  CameraControl c = control();
  c.changeSpeed(2);
  EXPECT_NEAR(c.speed(), size() / 4 * 1.44, 1e-9 * size());
  c.fly({0, 1, 0}, 2);
  const dvec3 way = c.view().eye - view().eye;
  EXPECT_NEAR(glm::length(way), 2 * c.speed(), 1e-9 * size());
  EXPECT_GT(glm::dot(glm::normalize(way), glm::normalize(view().target - view().eye)), 1 - 1e-9);
  c.fly({0, 0, 1}, 1);
  EXPECT_NEAR(c.view().eye.z - view().eye.z - way.z, c.speed(), 1e-9 * size()) << "up is the world's";
}

TEST_P(CameraControlTest, LooksFromTheFrontTheRightAndTheTop) {
  CameraControl c = control();
  c.turnTo(0, 0);
  EXPECT_NEAR(glm::normalize(c.view().eye - c.view().target).y, -1, 1e-9);
  c.turnTo(kPi / 2, 0);
  EXPECT_NEAR(glm::normalize(c.view().eye - c.view().target).x, 1, 1e-9);
  c.turnTo(0, kPi / 2);
  EXPECT_NEAR(glm::normalize(c.view().eye - c.view().target).z, 1, 1e-4);
  EXPECT_NEAR(axesOf(c.view()).right.x, 1, 1e-9);
}

// A ball touches the closer edges of the picture exactly.
TEST_P(CameraControlTest, ABallIsFramedExactly) {
  for (const double aspect : {16.0 / 9, 1.0, 0.5}) {
    CameraControl c = control();
    const dvec3 center = dvec3(3, -1, 2) * size();
    const double radius = 0.7 * size();
    c.frame(center, radius, aspect);
    // The cone from the eye around the ball.
    const double half = std::asin(radius / glm::length(center - c.view().eye));
    const double edge = std::atan(std::tan(c.view().verticalFov / 2) * std::min(1.0, aspect));
    EXPECT_NEAR(half, edge, 1e-9);
    expectNear(projected(c.view(), center), {0, 0});
  }
}

TEST_P(CameraControlTest, StaysFiniteAndUprightWhateverIsDone) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> way(-2, 2);
  CameraControl c = control();
  for (int i = 0; i < 10'000; ++i) {
    const dvec2 drag(way(random), way(random));
    switch (random() % 7) {
      case 0:
        c.orbit(drag);
        break;
      case 1:
        c.look(drag);
        break;
      case 2:
        c.pan(drag * 0.01);
        break;
      case 3:
        c.dolly(way(random), c.view().target);
        break;
      case 4:
        c.fly({drag.x, drag.y, 1}, 0.01);
        break;
      case 5:
        c.changeSpeed(drag.x);
        break;
      case 6:
        c.frame(dvec3(drag, 1) * size(), size(), 1.5);
        break;
    }
    const ViewAxes axes = axesOf(c.view());
    ASSERT_TRUE(std::isfinite(glm::length(c.view().eye)));
    ASSERT_GT(axes.up.z, 0);
    ASSERT_NEAR(axes.right.z, 0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CameraControlTest, testing::Values(1e-6, 1.0, 1e6));

}  // namespace
}  // namespace latelight::view
