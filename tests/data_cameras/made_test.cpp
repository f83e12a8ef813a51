// Generated cameras (lists, orbits, points on spheres and in boxes) compared with geometric closed forms.
#include <set>

#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

TEST(ListTest, LooksAtItsTarget) {
  const auto cameras = made(R"({"type": "list", "fov": 60, "cameras": [
      {"name": "front", "eye": [1, 2, 5], "target": [1, 2, 0]},
      {"eye": [0, 4, 0], "target": [0, 0, 0], "up": [1, 0, 0], "fov": 90, "size": [64, 48]},
      {"eye": [0, 4, 0], "target": [0, 0, 0]}]})");
  ASSERT_EQ(cameras.size(), 3u);
  EXPECT_EQ(cameras[0].name, "front");
  EXPECT_EQ(cameras[0].width, 0u);
  expectNear(seenFrom(cameras[0], {1, 2, 0}), {0, 0, 5}, 1e-6);
  expectNear(seenFrom(cameras[0], {2, 3, 0}), {1, -1, 5}, 1e-6);
  // tan 30 degrees is half of the picture's height at distance 1.
  const dvec2 pixel = pixelOf(cameras[0], {1, 2 - 5 * std::tan(kPi / 6), 0}, 200, 100);
  EXPECT_NEAR(pixel.x, 100, 1e-4);
  EXPECT_NEAR(pixel.y, 100, 1e-4);
  EXPECT_EQ(cameras[1].name, "camera1");
  EXPECT_EQ(cameras[1].width, 64u);
  EXPECT_EQ(cameras[1].height, 48u);
  expectNear(seenFrom(cameras[1], {1, 0, 0}), {0, -1, 4}, 1e-6);  // its up direction is +X
  // For a camera that looks straight down, up is away from the front (+Z).
  expectNear(seenFrom(cameras[2], {0, 0, -1}), {0, -1, 4}, 1e-6);
}

TEST(ListTest, TakesPosesOfBothCameraFrames) {
  // A camera at (1, 2, 3) that looks along +X with Y up: right is +Z, down is -Y.
  const auto cameras = made(R"({"type": "list", "cameras": [
      {"pose": [[0, 0, 1, 1], [0, -1, 0, 2], [1, 0, 0, 3], [0, 0, 0, 1]]},
      {"pose": [[0, 0, -1, 1], [0, 1, 0, 2], [1, 0, 0, 3], [0, 0, 0, 1]], "frame": "opengl"}]})");
  for (const JobCamera& camera : cameras) {
    expectNear(eyeOf(camera), {1, 2, 3}, 1e-6);
    expectNear(seenFrom(camera, {5, 2, 3}), {0, 0, 4}, 1e-6);
    expectNear(seenFrom(camera, {5, 2, 4}), {1, 0, 4}, 1e-6);
    expectNear(seenFrom(camera, {5, 1, 3}), {0, 1, 4}, 1e-6);
  }
}

TEST(ListTest, KProjectsAsItSays) {
  const auto cameras = made(R"({"type": "list", "K": [[500, 0, 300], [0, 500, 260], [0, 0, 1]], "size": [640, 480],
      "cameras": [{"pose": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}]})");
  EXPECT_FALSE(cameras[0].camera.lens);
  for (const dvec3 p : {dvec3(0, 0, -1), dvec3(0.3, -0.2, -2), dvec3(-1, 0.7, -3)}) {
    const dvec2 pixel = pixelOf(cameras[0], p, 640, 480);
    EXPECT_NEAR(pixel.x, 500 * p.x / -p.z + 300, 1e-3);
    EXPECT_NEAR(pixel.y, 500 * -p.y / -p.z + 260, 1e-3);
  }
}

TEST(ListTest, WhatIsNoFieldOfViewIsALens) {
  const auto cameras = made(R"({"type": "list", "cameras": [
      {"eye": [0, 0, 5], "K": [[500, 0, 320], [0, 400, 240], [0, 0, 1]], "size": [640, 480]},
      {"eye": [0, 0, 5], "K": [[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]], "size": [640, 480], "pixelCenter": 0,
       "model": "opencv", "distortion": [0.1, -0.2, 0.01, 0.02, 0.3]},
      {"eye": [0, 0, 5], "model": "fisheye", "K": [[300, 0, 320], [0, 300, 240], [0, 0, 1]], "size": [640, 480],
       "distortion": [0.1, 0.2, 0.3, 0.4]},
      {"eye": [0, 0, 5], "model": "equirectangular", "size": [200, 100]}, {"eye": [0, 0, 5], "model": "cubemap"}]})");
  using enum scene::LensModel;
  const auto lens = [&](size_t i) { return cameras[i].camera.lens.value(); };
  EXPECT_EQ(lens(0).model, Pinhole);
  EXPECT_EQ(lens(0).fy, 400);
  EXPECT_EQ(lens(1).model, OpenCv);
  EXPECT_EQ(lens(1).cx, 320);
  EXPECT_EQ(lens(1).cy, 240);
  EXPECT_THAT(lens(1).distortion, testing::ElementsAre(0.1, -0.2, 0.01, 0.02, 0.3, 0, 0, 0));
  EXPECT_EQ(lens(2).model, Fisheye);
  EXPECT_THAT(lens(2).distortion, testing::ElementsAre(0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0));
  EXPECT_EQ(lens(3).model, Equirectangular);
  EXPECT_EQ(cameras[3].width, 200u);
  EXPECT_EQ(lens(4).model, CubeMap);
}

TEST(SceneTest, GivesTheScenesOwnCameras) {
  const scene::Camera& own = boxes().cameras.at(0);
  for (const auto& cameras : {made("null"), made(R"({"type": "scene", "names": [")" + own.name + R"("]})")}) {
    ASSERT_GE(cameras.size(), 1u);
    EXPECT_EQ(cameras[0].name, own.name);
    EXPECT_EQ(cameras[0].camera.toWorld, own.toWorld);
    EXPECT_EQ(cameras[0].camera.verticalFov, own.verticalFov);
  }
}

TEST(OrbitTest, IsACircle) {
  const auto cameras = made(R"({"type": "orbit", "count": 8, "elevation": 30, "distance": 4, "target": [1, 2, 3]})");
  ASSERT_EQ(cameras.size(), 8u);
  for (size_t i = 0; i < 8; ++i) {
    const double azimuth = i * kPi / 4, flat = 4 * std::cos(kPi / 6);
    expectNear(eyeOf(cameras[i]), {1 + flat * std::sin(azimuth), 2 + 2, 3 + flat * std::cos(azimuth)}, 1e-6);
    expectNear(seenFrom(cameras[i], {1, 2, 3}), {0, 0, 4}, 4e-6);
    EXPECT_NEAR(seenFrom(cameras[i], {1, 3, 3}).x, 0, 4e-6);  // upright
  }
  EXPECT_EQ(cameras[7].name, "orbit7");
}

TEST(OrbitTest, MaySpiralAndStopAtItsEnd) {
  const auto cameras = made(
      R"({"type": "orbit", "count": 5, "azimuth": [-90, 90], "elevation": [0, 60], "distance": [1, 3], "target": [0, 0, 0]})");
  expectNear(eyeOf(cameras[0]), {-1, 0, 0}, 1e-6);
  expectNear(eyeOf(cameras[2]), {0, 2 * 0.5, 2 * std::cos(kPi / 6)}, 1e-6);
  expectNear(eyeOf(cameras[4]), {3 * 0.5, 3 * std::cos(kPi / 6), 0}, 1e-6);
}

TEST(OrbitTest, FitsItsTarget) {
  // The bounds of a unit cube around its center have the radius sqrt(3) / 2.
  const std::string node = R"("target": {"node": "/boxes/matte"})";
  const auto cameras = made(R"({"type": "orbit", "count": 1, "elevation": 0, "fov": 60, )" + node + "}");
  const dvec3 middle(-3.25, 1, -1.25);
  expectNear(eyeOf(cameras[0]), middle + dvec3(0, 0, 1.04 * 0.75 * std::sqrt(3) / 0.5), 1e-5);
}

TEST(SphereTest, GridIsOnTheSphereAndEven) {
  const auto cameras =
      made(R"({"type": "sphere", "count": 400, "radius": 20, "target": [1, 0, -1], "rejectInside": false})");
  ASSERT_EQ(cameras.size(), 400u);
  std::vector<dvec3> points;
  dvec3 sum(0);
  for (const JobCamera& camera : cameras) {
    const dvec3 p = eyeOf(camera) - dvec3(1, 0, -1);
    EXPECT_NEAR(glm::length(p), 20, 1e-5);
    expectNear(seenFrom(camera, {1, 0, -1}), {0, 0, 20}, 1e-4);
    points.push_back(p / 20.0);
    sum += points.back();
  }
  EXPECT_LT(glm::length(sum) / 400, 2e-3);
  // Each point has an area of about 4 pi / 400. Nearest neighbors on a grid of that density are sqrt(4 pi / 400) = 0.18
  // apart; random points would come as close as 0.01.
  for (size_t i = 0; i < points.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_GT(glm::length(points[i] - points[j]), 0.13);
}

TEST(SphereTest, RandomPointsAreUniform) {
  const auto cameras = made(
      R"({"type": "sphere", "count": 8000, "points": "random", "radius": [20, 30], "target": [0, 0, 0], "rejectInside": false})");
  // By Archimedes, equal steps of height have equal areas, as do equal steps of azimuth.
  std::vector<uint32_t> cells(20);
  for (const JobCamera& camera : cameras) {
    const dvec3 p = eyeOf(camera);
    ASSERT_TRUE(glm::length(p) >= 19.999 && glm::length(p) <= 30.001);
    const double height = p.y / glm::length(p) * 0.5 + 0.5, turn = std::atan2(p.x, p.z) / (2 * kPi) + 0.5;
    ++cells[std::min<size_t>(4, static_cast<size_t>(height * 5)) * 4 +
            std::min<size_t>(3, static_cast<size_t>(turn * 4))];
  }
  double chi = 0;
  for (const uint32_t count : cells) chi += (count - 400.0) * (count - 400.0) / 400.0;
  EXPECT_LT(chi, 42.31);  // 19 degrees of freedom: one time in 600
}

TEST(SphereTest, KeepsToItsElevations) {
  const auto cameras = made(
      R"({"type": "sphere", "count": 50, "radius": 30, "target": [0, 0, 0], "elevation": [10, 45], "rejectInside": false})");
  double least = 90, most = -90;
  for (const JobCamera& camera : cameras) {
    const double elevation = std::asin(eyeOf(camera).y / 30) * 180 / kPi;
    least = std::min(least, elevation), most = std::max(most, elevation);
  }
  EXPECT_GT(least, 10);
  EXPECT_LT(least, 11);
  EXPECT_LT(most, 45);
  EXPECT_GT(most, 44);
}

TEST(BoxTest, RandomPointsAreUniform) {
  const auto cameras = made(
      R"({"type": "box", "count": 8000, "min": [20, 0, 0], "max": [25, 2, 2], "target": "random", "rejectInside": false})");
  std::vector<uint32_t> cells(20), views(8);
  for (const JobCamera& camera : cameras) {
    const dvec3 p = eyeOf(camera);
    const auto cell = [](double share, int count) { return std::min(count - 1, static_cast<int>(share * count)); };
    ++cells[static_cast<size_t>(cell((p.x - 20) / 5, 5) * 4 + cell(p.y / 2, 2) * 2 + cell(p.z / 2, 2))];
    const dvec3 away(seenFrom(camera, p + dvec3(1, 0, 0)).z, seenFrom(camera, p + dvec3(0, 1, 0)).z,
                     seenFrom(camera, p + dvec3(0, 0, 1)).z);
    ++views[(away.x > 0) + 2 * (away.y > 0) + 4 * (away.z > 0)];
  }
  double chi = 0, chiViews = 0;
  for (const uint32_t count : cells) chi += (count - 400.0) * (count - 400.0) / 400.0;
  for (const uint32_t count : views) chiViews += (count - 1000.0) * (count - 1000.0) / 1000.0;
  EXPECT_LT(chi, 42.31);
  EXPECT_LT(chiViews, 24.3);  // 7 degrees of freedom: one time in 1000
}

TEST(CamerasTest, DependOnTheSeedAlone) {
  const std::string spec = R"({"type": "box", "count": 5, "min": [20, 0, 0], "max": [25, 2, 2]})";
  const auto first = made(spec, boxes(), 1), again = made(spec, boxes(), 1), other = made(spec, boxes(), 2);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(first[i].camera.toWorld, again[i].camera.toWorld);
    EXPECT_NE(first[i].camera.toWorld, other[i].camera.toWorld);
  }
  // Adding cameras does not change the first ones.
  const auto more = made(R"({"type": "box", "count": 9, "min": [20, 0, 0], "max": [25, 2, 2]})");
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(first[i].camera.toWorld, more[i].camera.toWorld);
}

TEST(CamerasTest, HaveUniqueNamesFitForFiles) {
  const auto cameras = made(R"([
      {"type": "list", "cameras": [{"name": "a/b", "eye": [0, 0, 5]}, {"name": "a/b", "eye": [0, 0, 6]},
                                   {"name": "..", "eye": [0, 0, 7]}, {"name": "a_b-2", "eye": [0, 0, 8]}]},
      {"type": "orbit", "count": 2, "distance": 20}, {"type": "orbit", "count": 2, "distance": 20}])");
  std::set<std::string> names;
  for (const JobCamera& camera : cameras) {
    EXPECT_TRUE(names.insert(camera.name).second) << camera.name;
    EXPECT_EQ(camera.name.find('/'), std::string::npos);
    EXPECT_EQ(camera.name, camera.camera.name);
  }
  EXPECT_EQ(cameras[0].name, "a_b");
  EXPECT_EQ(cameras[2].name, "camera2");
}

}  // namespace
}  // namespace latelight::data::test
