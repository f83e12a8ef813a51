// Paths, pairs and rigs.
#include "data/cameras/path.h"

#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

TEST(PathTest, PassesItsKeyFrames) {
  const auto cameras = made(R"({"type": "path", "count": 31, "keys": [
      {"time": 0, "eye": [0, 1, 5], "target": [0, 0, 0]}, {"time": 1, "eye": [4, 2, 3], "target": [0, 0, 0], "fov": 60},
      {"time": 3, "eye": [5, 1, -2], "target": [1, 0, 0], "fov": 60}]})");
  ASSERT_EQ(cameras.size(), 31u);
  expectNear(eyeOf(cameras[0]), {0, 1, 5}, 1e-6);
  expectNear(eyeOf(cameras[10]), {4, 2, 3}, 1e-6);
  expectNear(eyeOf(cameras[30]), {5, 1, -2}, 1e-6);
  expectNear(seenFrom(cameras[10], {0, 0, 0}), {0, 0, std::sqrt(29.0)}, 2e-6);
  expectNear(seenFrom(cameras[30], {1, 0, 0}), {0, 0, std::sqrt(21.0)}, 2e-6);
  EXPECT_NEAR(cameras[0].camera.verticalFov, 40 * kPi / 180, 1e-6);
  EXPECT_NEAR(cameras[5].camera.verticalFov, 50 * kPi / 180, 1e-6);
  EXPECT_NEAR(cameras[25].camera.verticalFov, 60 * kPi / 180, 1e-6);
  // Neither positions nor orientations jump.
  for (size_t i = 1; i < cameras.size(); ++i) {
    EXPECT_LT(glm::length(eyeOf(cameras[i]) - eyeOf(cameras[i - 1])), 0.7);
    EXPECT_GT(glm::dot(cameras[i].camera.toWorld[1], cameras[i - 1].camera.toWorld[1]), 0.97f);
  }
}

TEST(PathTest, TakesFramesASecond) {
  const auto cameras = made(R"({"type": "path", "fps": 4, "keys": [
      {"time": 10, "eye": [0, 0, 1], "target": [0, 0, 0]}, {"time": 11.6, "eye": [0, 0, 9], "target": [0, 0, 0]}]})");
  ASSERT_EQ(cameras.size(), 7u);  // at 10, 10.25, ... 11.5
  expectNear(eyeOf(cameras[6]), {0, 0, 1 + 8 * 1.5 / 1.6}, 1e-5);
}

// The last key frame is a frame if it is a multiple of 1 / fps after the first, up to the rounding of its time.
TEST(PathTest, HasAFrameAtTheLastKey) {
  for (const double start : {0.0, 0.1, 12.7, 1305031102.1})
    for (const double fps : {10.0, 24.0, 29.97, 30.0, 60.0, 100.0})
      for (const int frames : {1, 2, 3, 7, 29, 30}) {
        const auto cameras = made(fmt::format(R"({{"type": "path", "fps": {}, "keys": [
            {{"time": {}, "eye": [0, 0, 1], "target": [0, 0, 0]}},
            {{"time": {}, "eye": [0, 0, 9], "target": [0, 0, 0]}}]}})",
                                              fps, start, start + frames / fps));
        ASSERT_EQ(cameras.size(), static_cast<size_t>(frames) + 1) << start << " " << fps;
        expectNear(eyeOf(cameras.back()), {0, 0, 9}, 1e-4);
      }
}

// Points on a line at distances 1, 4 and 9, so the knot intervals are 1, 2 and 3, and Neville's scheme yields this
// polynomial.
TEST(CatmullRomTest, HasCentripetalKnots) {
  const std::array<dvec3, 4> points{dvec3(0), dvec3(1, 0, 0), dvec3(5, 0, 0), dvec3(14, 0, 0)};
  for (const double share : {0.0, 0.25, 0.5, 1.0}) {
    const double t = 1 + 2 * share;  // knots 0, 1, 3, 6
    const double a = t, b = 1 + 4 * (t - 1) / 2, c = 5 + 9 * (t - 3) / 3;
    const double d = (a * (3 - t) + b * t) / 3, e = (b * (6 - t) + c * (t - 1)) / 5;
    EXPECT_NEAR(catmullRom(points, share).x, (d * (3 - t) + e * (t - 1)) / 2, 1e-12);
  }
  EXPECT_EQ(catmullRom({dvec3(1), dvec3(1), dvec3(1), dvec3(1)}, 0.5), dvec3(1));
}

TEST(SquadTest, TurnsEvenlyAboutOneAxis) {
  const auto turn = [](double angle) { return dvec4(std::cos(angle / 2), 0, std::sin(angle / 2), 0); };
  const auto expectTurn = [&](dvec4 q, double angle) { EXPECT_LE(glm::length(q - turn(angle)), 1e-12); };
  expectTurn(slerp(turn(0.2), turn(1.4), 0.25), 0.5);
  // About a single axis, squad is Shoemake's parabola of the angles, and with equal steps it is linear.
  const double angles[] = {0.1, 0.4, 0.7, 1.0};
  dvec4 q[4];
  for (int i = 0; i < 4; ++i) q[i] = turn(angles[i]);
  const dvec4 a = squadControl(q[0], q[1], q[2]), b = squadControl(q[1], q[2], q[3]);
  expectTurn(squad(q[1], a, b, q[2], 0.3), 0.49);
  const dvec4 bent = squadControl(turn(0), q[1], q[2]);  // 0.4 - ((0.7 - 0.4) + (0 - 0.4)) / 4
  expectTurn(bent, 0.425);
}

TEST(StereoTest, IsAPairSideBySide) {
  const auto cameras = made(R"({"type": "stereo", "baseline": 0.12, "cameras":
      {"type": "list", "fov": 50, "size": [64, 48], "cameras": [{"name": "head", "eye": [0, 0, 5], "target": [0, 0, 0]}]}})");
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "head-left");
  EXPECT_EQ(cameras[1].name, "head-right");
  expectNear(eyeOf(cameras[0]), {0, 0, 5}, 1e-6);
  expectNear(eyeOf(cameras[1]), {0.12, 0, 5}, 1e-6);
  expectNear(seenFrom(cameras[1], {0.12, 0, 0}), {0, 0, 5}, 1e-6);
  EXPECT_EQ(cameras[1].width, 64u);
}

TEST(RigTest, PutsItsMembersWhereOffsetsSay) {
  // The base looks along -Z; the second member looks to its right and has its own lens.
  const auto cameras = made(R"({"type": "rig", "offsets": [
      {"name": "front", "translation": [0.5, -1, 2]},
      {"name": "side", "pose": [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], "fov": 90, "size": [32, 32]}],
      "cameras": {"type": "list", "cameras": [{"name": "car", "eye": [1, 1, 1], "target": [1, 1, 0]}]}})");
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "car-front");
  expectNear(eyeOf(cameras[0]), {1.5, 2, -1}, 1e-6);
  expectNear(seenFrom(cameras[1], {4, 1, 1}), {0, 0, 3}, 1e-6);
  expectNear(seenFrom(cameras[1], {4, 1, 2}), {1, 0, 3}, 1e-6);
  EXPECT_NEAR(cameras[0].camera.verticalFov, 40 * kPi / 180, 1e-6);
  EXPECT_NEAR(cameras[1].camera.verticalFov, kPi / 2, 1e-6);
  EXPECT_EQ(cameras[1].width, 32u);
}

}  // namespace
}  // namespace latelight::data::test
