// Lenses compared with an independent implementation of OpenCV's formulas, and with closed forms.
#include "scene/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "base/error.h"

namespace latelight::scene {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = 3.14159265358979323846;

Lens lensOf(LensModel model, std::array<double, 8> distortion = {}) {
  return {model, 640, 480, 400, 410, 330, 235, distortion};
}

const std::array<double, 8> kBarrel{-0.28, 0.07, 1.2e-3, -8e-4, -0.005};
const std::array<double, 8> kPincushion{0.15, 0.05, -5e-4, 3e-4, 0.01};
const std::array<double, 8> kRational{0.9, 0.1, 1e-4, 2e-4, 0.01, 1.2, 0.25, 0.02};
const std::array<double, 8> kBent{-0.03, 0.012, -0.004, 0.0007};

// In the order of OpenCV's calib3d manual: k1 k2 p1 p2 k3 k4 k5 k6.
dvec2 openCv(const Lens& lens, dvec3 v) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = lens.distortion;
  const double x = v.x / v.z, y = v.y / v.z, r2 = x * x + y * y;
  const double radial =
      (1 + k1 * r2 + k2 * r2 * r2 + k3 * std::pow(r2, 3)) / (1 + k4 * r2 + k5 * r2 * r2 + k6 * std::pow(r2, 3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {lens.fx * xd + lens.cx, lens.fy * yd + lens.cy};
}

dvec2 openCvFisheye(const Lens& lens, dvec3 v) {
  const double theta = std::acos(v.z / glm::length(v)), angle = std::atan2(v.y, v.x);
  double bent = theta;
  for (int i = 0; i < 4; ++i) bent += lens.distortion[size_t(i)] * std::pow(theta, 3 + 2 * i);
  return {lens.fx * bent * std::cos(angle) + lens.cx, lens.fy * bent * std::sin(angle) + lens.cy};
}

dvec3 direction(double theta, double angle) {
  return {std::sin(theta) * std::cos(angle), std::sin(theta) * std::sin(angle), std::cos(theta)};
}

TEST(LensTest, ProjectsAsOpenCvDoes) {
  for (const auto& distortion : {kBarrel, kPincushion, kRational}) {
    const Lens lens = lensOf(LensModel::OpenCv, distortion);
    for (double theta = 0; theta < 0.6; theta += 0.05)
      for (double angle = 0; angle < 6.2; angle += 0.3) {
        const dvec3 v = 3.0 * direction(theta, angle);
        const std::optional<dvec2> pixel = LensProjection(lens).project(v);
        ASSERT_TRUE(pixel);
        EXPECT_LT(glm::length(*pixel - openCv(lens, v)), 1e-10);
      }
  }
  const Lens fisheye = lensOf(LensModel::Fisheye, kBent);
  for (double theta = 0.01; theta < 2.5; theta += 0.05)
    for (double angle = 0; angle < 6.2; angle += 0.3) {
      const std::optional<dvec2> pixel = LensProjection(fisheye).project(0.5 * direction(theta, angle));
      ASSERT_TRUE(pixel);
      EXPECT_LT(glm::length(*pixel - openCvFisheye(fisheye, direction(theta, angle))), 1e-9);
    }
}

// Every pixel that has a direction is the projection of that direction.
void expectRoundTrips(const Lens& lens, double leastShare) {
  const LensProjection projection(lens);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(0, lens.width), y(0, lens.height);
  int seen = 0;
  constexpr int kPixels = 20000;
  for (int i = 0; i < kPixels; ++i) {
    const dvec2 pixel(x(random), y(random));
    const std::optional<dvec3> ray = projection.unproject(pixel);
    if (!ray) continue;
    ++seen;
    EXPECT_NEAR(glm::length(*ray), 1, 1e-14);
    const std::optional<dvec2> again = projection.project(*ray);
    ASSERT_TRUE(again) << pixel.x << ' ' << pixel.y;
    EXPECT_LT(glm::length(*again - pixel), 1e-8) << pixel.x << ' ' << pixel.y;
  }
  EXPECT_GE(seen, leastShare * kPixels);
}

TEST(LensTest, PixelsAreWhereTheirDirectionsAreSeen) {
  expectRoundTrips(lensOf(LensModel::Pinhole), 1);
  for (const auto& distortion : {std::array<double, 8>{}, kBarrel, kPincushion, kRational})
    expectRoundTrips(lensOf(LensModel::OpenCv, distortion), 1);
  expectRoundTrips(lensOf(LensModel::Fisheye, kBent), 1);
  expectRoundTrips(
      {.model = LensModel::Fisheye, .width = 640, .height = 640, .fx = 110, .fy = 110, .cx = 320, .cy = 320},
      0.78 * 1.0);
  expectRoundTrips({.model = LensModel::Equirectangular, .width = 640, .height = 320}, 1);
  expectRoundTrips({.model = LensModel::CubeMap, .width = 600, .height = 100}, 1);
}

// A direction in the lens's valid region is recovered, up to the region's boundary.
TEST(LensTest, DirectionsAreFoundAgain) {
  for (const auto& distortion : {kBarrel, kPincushion, kRational}) {
    const Lens lens = lensOf(LensModel::OpenCv, distortion);
    const LensProjection projection(lens);
    int found = 0;
    for (double theta = 0; theta < 1.55; theta += 0.01)
      for (double angle = 0; angle < 6.2; angle += 0.2) {
        const std::optional<dvec2> pixel = projection.project(direction(theta, angle));
        if (!pixel) continue;
        const std::optional<dvec3> ray = projection.unproject(*pixel);
        ASSERT_TRUE(ray) << theta << ' ' << angle;
        EXPECT_LT(glm::length(*ray - direction(theta, angle)), 1e-6) << theta;
        ++found;
      }
    EXPECT_GT(found, 1000);
  }
}

// With only k1 = -0.3, r (1 - 0.3 r^2) has its maximum at r = 1 / sqrt(0.9), where it is 2/3 of that.
TEST(LensTest, NothingIsSeenBeyondTheTurn) {
  const Lens lens = lensOf(LensModel::OpenCv, {-0.3});
  const LensProjection projection(lens);
  const double turn = 1 / std::sqrt(0.9);
  EXPECT_TRUE(projection.project({turn * 0.9999, 0, 1}));
  EXPECT_FALSE(projection.project({turn * 1.0001, 0, 1}));
  EXPECT_FALSE(projection.project({0, 0, -1}));
  const dvec2 end(lens.cx + lens.fx * turn * 2 / 3, lens.cy);
  EXPECT_TRUE(projection.unproject(end - dvec2(0.01, 0)));
  EXPECT_FALSE(projection.unproject(end + dvec2(0.01, 0)));
  // theta (1 - 0.1 theta^2): sqrt(10 / 3).
  const LensProjection fisheye(lensOf(LensModel::Fisheye, {-0.1}));
  EXPECT_TRUE(fisheye.project(direction(std::sqrt(10.0 / 3) - 1e-6, 1)));
  EXPECT_FALSE(fisheye.project(direction(std::sqrt(10.0 / 3) + 1e-6, 1)));
}

// --- poles ----------------------------------------------------------------------------------------------------------

// Returns the tangent of the angle to the axis under which a pixel, right of the principal point, sees.
std::optional<double> tangentAt(const Lens& lens, double distance) {
  const std::optional<dvec3> ray = LensProjection(lens).unproject({lens.cx + lens.fx * distance, lens.cy});
  return ray ? std::optional(ray->x / ray->z) : std::nullopt;
}

// r / (1 - a r^2) rises to infinity at r = 1 / sqrt(a). It is q at r = (sqrt(1 + 4 a q^2) - 1) / (2 a q).
TEST(LensTest, UpToAPoleEveryPixelHasARay) {
  for (const double a : {1e-9, 0.05, 0.25, 1.0, 3.0, 20.0, 1e4}) {
    const Lens lens = lensOf(LensModel::OpenCv, {0, 0, 0, 0, 0, -a});
    for (const double q : {1e-6, 0.1, 1 / std::sqrt(a), 0.5 / std::sqrt(a), 3.0, 20.0}) {
      const std::optional<double> r = tangentAt(lens, q);
      ASSERT_TRUE(r) << a << ' ' << q;
      const double expected = 2 * q / (std::sqrt(1 + 4 * a * q * q) + 1);
      EXPECT_NEAR(*r / expected, 1, 1e-9) << a << ' ' << q;
    }
    const LensProjection projection(lens);
    EXPECT_TRUE(projection.project({0.999 / std::sqrt(a), 0, 1})) << a;
    EXPECT_FALSE(projection.project({1.001 / std::sqrt(a), 0, 1})) << a;
  }
  EXPECT_FALSE(LensProjection(lensOf(LensModel::OpenCv, {0, 0, 0, 0, 0, -1})).project({1, 0, 1}));
  // The pole is at r = 10, far outside of the image.
  expectRoundTrips(lensOf(LensModel::OpenCv, {0, 0, 0, 0, 0, 0, 0, -1e-6}), 1);
  expectRoundTrips(lensOf(LensModel::OpenCv, {-0.1, 0, 1e-3, -5e-4, 0, -0.3, 0.1, -0.02}), 1);
  // (1 - r^2)^2, without a change of sign at the pole.
  expectRoundTrips(lensOf(LensModel::OpenCv, {0, 0, 0, 0, 0, -2, 1}), 1);
  // The numerator is equal to the denominator, so that there is no distortion.
  expectRoundTrips(lensOf(LensModel::OpenCv, {-0.05, 0, 0, 0, 0, -0.05}), 1);
}

// Returns where r (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) first reaches a value, before its
// first extremum and its first pole: by small steps, then by bisection. Null if it does not.
std::optional<double> firstRadiusAt(const Lens& lens, double value) {
  const double k1 = lens.distortion[0], k2 = lens.distortion[1], k3 = lens.distortion[4];
  const double k4 = lens.distortion[5], k5 = lens.distortion[6], k6 = lens.distortion[7];
  const auto below = [&](double x) { return 1 + k4 * x + k5 * x * x + k6 * x * x * x; };
  const auto reached = [&](double r) {
    const double x = r * r;
    return below(x) <= 0 || r * (1 + k1 * x + k2 * x * x + k3 * x * x * x) / below(x) >= value;
  };
  const auto radius = [&](double r) { return openCv(lens, {r, 0, 1}).x; };
  double low = 0, high = 0;
  while (!reached(high)) {
    if (high > 50 || (high > 0 && radius(high) <= radius(low))) return std::nullopt;
    low = high;
    high += 1e-3;
  }
  for (int i = 0; i < 60; ++i) (reached(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  // Just below a pole at which the numerator is negative, the function has turned.
  return std::abs(radius(low) - (lens.cx + lens.fx * value)) < 1e-3 ? std::optional(low) : std::nullopt;
}

// Most of these denominators have a negative coefficient, and many of them a pole.
TEST(LensTest, RationalLensesAreInverted) {
  std::mt19937 random(5);
  std::normal_distribution<double> coefficient(0, 0.4);
  int negative = 0, rays = 0;
  for (int i = 0; i < 200; ++i) {
    Lens lens = lensOf(LensModel::OpenCv);
    for (const size_t k : {0, 1, 4, 5, 6, 7}) lens.distortion[k] = random() % 2 ? coefficient(random) : 0;
    negative += lens.distortion[5] < 0 || lens.distortion[6] < 0 || lens.distortion[7] < 0;
    for (const double q : {0.05, 0.2, 0.4, 0.8, 1.5}) {
      // A small change of the value near an extremum decides whether there is a ray.
      const std::optional<double> expected = firstRadiusAt(lens, q), further = firstRadiusAt(lens, q + 2e-3);
      const std::optional<double> r = tangentAt(lens, q);
      if (expected.has_value() != further.has_value()) continue;
      ASSERT_EQ(r.has_value(), expected.has_value()) << i << ' ' << q;
      if (!r) continue;
      EXPECT_NEAR(*r, *expected, 1e-7) << i << ' ' << q;
      ++rays;
    }
  }
  EXPECT_GT(negative, 100);
  EXPECT_GT(rays, 500);
}

TEST(LensTest, ClosedForms) {
  const LensProjection equirectangular({.model = LensModel::Equirectangular, .width = 400, .height = 200});
  const auto expectNear = [](std::optional<dvec3> ray, dvec3 expected) {
    ASSERT_TRUE(ray);
    EXPECT_LT(glm::length(*ray - glm::normalize(expected)), 1e-14) << ray->x << ' ' << ray->y << ' ' << ray->z;
  };
  expectNear(equirectangular.unproject({200, 100}), {0, 0, 1});
  expectNear(equirectangular.unproject({300, 100}), {1, 0, 0});
  expectNear(equirectangular.unproject({100, 100}), {-1, 0, 0});
  expectNear(equirectangular.unproject({0, 100}), {0, 0, -1});
  expectNear(equirectangular.unproject({200, 50}), {0, -1, 1});
  EXPECT_EQ(equirectangular.depthOf({0, 0.6, 0.8}), 1);
  const LensProjection cube({.model = LensModel::CubeMap, .width = 600, .height = 100});
  const dvec3 axes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (int face = 0; face < 6; ++face) expectNear(cube.unproject({100 * face + 50, 50}), axes[face]);
  expectNear(cube.unproject({450, 0}), {0, -1, 1});    // ahead, its upper edge
  expectNear(cube.unproject({350, 100}), {0, -1, 1});  // above, its lower edge: the same
  expectNear(cube.unproject({250, 0}), {0, 1, 1});     // below: its upper edge is the lower edge of the front face
  expectNear(cube.unproject({0.0, 50}), {1, 0, 1});    // right: its left edge is the right edge of the front face
  EXPECT_EQ(cube.depthOf({0.6, 0, -0.8}), 0.8);
  const LensProjection fisheye(
      {.model = LensModel::Fisheye, .width = 400, .height = 400, .fx = 60, .fy = 60, .cx = 200, .cy = 200});
  expectNear(fisheye.unproject({200 + 60 * kPi / 2, 200}), {1, 0, 0});
  expectNear(fisheye.unproject({200, 200 + 60 * 2.5}), {0, std::sin(2.5), std::cos(2.5)});
  EXPECT_FALSE(fisheye.unproject({200 + 60 * 3.15, 200}));
}

// theta = 0.01 r + 1e-5 r^2 has no turn; theta = 0.01 r - 2.5e-5 r^2 turns at r = 200, where it is 1.
TEST(LensTest, FThetaIsAPolynomialOfTheDistance) {
  Lens lens{.model = LensModel::FTheta, .width = 640, .height = 480, .fx = 1, .fy = 1, .cx = 320, .cy = 240};
  lens.distortion = {0, 0.01, 1e-5};
  for (const double r : {0.0, 1.0, 50.0, 150.0, 230.0}) {
    const double theta = 0.01 * r + 1e-5 * r * r;
    for (double angle = 0; angle < 6.2; angle += 0.5) {
      const dvec2 pixel = dvec2(320, 240) + r * dvec2(std::cos(angle), std::sin(angle));
      const std::optional<dvec3> ray = LensProjection(lens).unproject(pixel);
      const std::optional<dvec2> again = LensProjection(lens).project(direction(theta, angle));
      ASSERT_TRUE(ray && again);
      EXPECT_LT(glm::length(*ray - direction(theta, angle)), 1e-14);
      EXPECT_LT(glm::length(*again - pixel), 1e-9);
    }
  }
  EXPECT_FALSE(LensProjection(lens).unproject({320 + 255, 240}));  // beyond 180 degrees
  expectRoundTrips(lens, 0.6);
  // The same picture, four times as large in each direction.
  const Lens large = scaledTo(lens, 2560, 1920);
  EXPECT_LT(glm::length(*LensProjection(large).unproject({1600, 1200}) - *LensProjection(lens).unproject({400, 300})),
            1e-14);
  lens.distortion = {0, 0.01, -2.5e-5};
  const LensProjection turning(lens);
  EXPECT_TRUE(turning.unproject({320 + 199.9, 240}));
  EXPECT_FALSE(turning.unproject({320 + 200.1, 240}));
  EXPECT_TRUE(turning.project(direction(1 - 1e-6, 1)));
  EXPECT_FALSE(turning.project(direction(1 + 1e-6, 1)));
}

// With k0 above 0, the principal point would see a cone of angle k0; its ray is the axis. With k0 = -0.2 and k1 = 0.1,
// angles are negative up to r = 2: there are no rays.
TEST(LensTest, FThetaHasUnitRaysAtThePrincipalPoint) {
  Lens lens{.model = LensModel::FTheta, .width = 33, .height = 33, .fx = 1, .fy = 1, .cx = 16.5, .cy = 16.5};
  lens.distortion = {0.3, 0.02};
  const LensProjection cone(lens);
  EXPECT_EQ(cone.unproject({16.5, 16.5}), dvec3(0, 0, 1));
  EXPECT_LT(glm::length(*cone.unproject({17.5, 16.5}) - dvec3(std::sin(0.32), 0, std::cos(0.32))), 1e-15);
  lens.distortion = {-0.2, 0.1};
  const LensProjection hole(lens);
  EXPECT_FALSE(hole.unproject({16.5, 16.5}));
  EXPECT_FALSE(hole.unproject({16.5, 18.49}));
  EXPECT_LT(glm::length(*hole.unproject({16.5, 19.5}) - dvec3(0, std::sin(0.1), std::cos(0.1))), 1e-15);
}

TEST(LensTest, WhatAUserWrites) {
  const Lens lens = parseLens("--lens", "opencv:400,410,330,235,-0.28,0.07,1e-3,-8e-4,-0.005", 640, 480);
  EXPECT_EQ(lens, (Lens{LensModel::OpenCv, 640, 480, 400, 410, 330, 235, {-0.28, 0.07, 1e-3, -8e-4, -0.005}}));
  EXPECT_EQ(parseLens("--lens", "equirectangular", 64, 32).model, LensModel::Equirectangular);
  for (const char* wrong :
       {"", "fish", "opencv", "opencv:1,2,3", "opencv:0,1,2,3", "opencv:1,1,nan,2", "opencv:1,1,2,3,",
        "fisheye:1,1,2,3,4,5,6,7,8", "equirectangular:1", "pinhole:400,400,x,2", "cubemap"})
    EXPECT_THROW(parseLens("--lens", wrong, 64, 32), Error) << wrong;
  const Lens half = scaledTo(lens, 320, 240);
  const std::optional<dvec2> whole = LensProjection(lens).project({0.3, -0.2, 1}),
                             scaled = LensProjection(half).project({0.3, -0.2, 1});
  EXPECT_LT(glm::length(*whole * 0.5 - *scaled), 1e-12);
}

}  // namespace
}  // namespace latelight::scene
