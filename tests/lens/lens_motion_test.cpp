// Motion through lenses, compared with scene::LensProjection in double precision; and samples of lenses.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "base/error.h"
#include "render/lens/lens_calibration.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/lens_range.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using output::Aov;
using scene::LensModel;

constexpr uint32_t kSize = 72;

struct NamedLens {
  const char* name;
  scene::Lens lens;
};

const NamedLens kLenses[] = {
    {"opencv", {LensModel::OpenCv, 161, 121, 110, 112, 82, 57, {-0.28, 0.07, 1.2e-3, -8e-4, -0.005}}},
    {"rational", {LensModel::OpenCv, 640, 480, 400, 400, 320, 240, {0.9, 0.1, 1e-4, 2e-4, 0.01, 1.2, 0.25, 0.02}}},
    {"pole", {LensModel::OpenCv, 161, 121, 110, 112, 82, 57, {-0.05, 0.01, 1e-3, -5e-4, 0, -0.5, 0, 0}}},
    {"fisheye", {LensModel::Fisheye, 151, 151, 40, 40, 75, 76, {-0.03, 0.012, -0.004, 0.0007}}},
    {"ftheta", {LensModel::FTheta, 151, 151, 1, 1, 75, 76, {0, 0.025, 2e-5, -3e-7}}},
    {"equirectangular", {.model = LensModel::Equirectangular}},
    {"cubemap", {.model = LensModel::CubeMap}},
};

uint32_t heightOf(const NamedLens& lens) {
  return lens.lens.model == LensModel::CubeMap ? kSize / 6 : kSize;
}

TEST(LensProjectionOnTheDevice, EqualsThatOfTheHost) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const NamedLens& each : kLenses) {
    const uint32_t width = 600, height = each.lens.model == LensModel::CubeMap ? 100 : 500;
    const scene::Lens scaled = scene::scaledTo(each.lens, width, height);
    const scene::LensProjection host(scaled);
    const shared::LensCalibration device = calibrationOf(each.lens, width, height);
    size_t projected = 0;
    for (int i = 0; i < 4000; ++i) {
      const dvec3 v(normal(random), normal(random), normal(random));
      const auto expected = host.project(v);
      const shared::LensPoint point = shared::projectThroughLens(device, glm::vec3(v));
      // The device does not exclude directions at which tangential terms fold the image, far beyond its edges.
      if (!expected && each.lens.model == LensModel::OpenCv && v.z > 0 &&
          (v.x * v.x + v.y * v.y) / (v.z * v.z) < scene::turningPoint(scaled))
        continue;
      // Directions at the edge of what the lens projects may be rounded to either side.
      if (bool(expected) != (point.known != 0)) {
        EXPECT_NE(bool(host.project(v + 1e-4 * glm::length(v) * dvec3(0, 0, 1))),
                  bool(host.project(v - 1e-4 * glm::length(v) * dvec3(0, 0, 1))))
            << each.name;
        continue;
      }
      if (!expected) continue;
      ++projected;
      if (std::max(std::abs(expected->x), std::abs(expected->y)) < 2000) {
        EXPECT_LE(glm::length(dvec2(point.pixel) - *expected), 2e-3) << each.name;
      }
    }
    EXPECT_GT(projected, 200u) << each.name;
  }
}

class LensMotionTest : public RenderTest, public testing::WithParamInterface<NamedLens> {};

// The scene is at rest and the camera moves, so the previous position of each point is the projection of the point
// through the previous camera.
TEST_P(LensMotionTest, IsTheProjectionOfThePointThroughTheOtherCameras) {
  const scene::Scene& scene = hall();
  scene::Camera now = cameraOf(scene, kSize, kSize), before = now, after = now;
  for (scene::Camera* camera : {&now, &before, &after}) camera->lens = GetParam().lens;
  before.toWorld = glm::rotate(now.toWorld, 0.03, dvec3(0.3, 0.2, 1));
  before.toWorld[3] += glm::dvec4(0.1, -0.05, 0.02, 0);
  after.toWorld[3] += glm::dvec4(-0.2, 0.1, 0, 0);
  const uint32_t width = kSize, height = heightOf(GetParam());
  if (after.lens->fx > 0) after.lens->fx *= 1.02;  // it zooms
  Settings settings = settingsOf(width, height, {Aov::Position, Aov::Id, Aov::Motion});
  settings.axes = Axes::ZUp;
  settings.display = false;
  const dvec3 eye(now.toWorld[3]);
  settings.positionOrigin = {eye};
  SceneState moment;
  moment.previousCameras = {before};
  moment.nextCameras = {after};
  Renderer renderer(device(), scene, nullptr);
  const output::FrameOutput frame = std::move(renderer.render({&now, 1}, settings, moment).front());
  const auto motionTo = [&](const scene::Camera& other, dvec3 point, size_t pixel) -> std::optional<dvec2> {
    const glm::dmat4 fromWorld = glm::inverse(openCvPose(other, scene, true));
    const auto at = scene::LensProjection(scene::scaledTo(*other.lens, width, height))
                        .project(dvec3(fromWorld * glm::dvec4(point, 1)));
    if (!at) return std::nullopt;
    dvec2 motion = *at - (dvec2(pixel % width, pixel / width) + 0.5);
    if (other.lens->model == LensModel::Equirectangular) motion.x -= width * std::round(motion.x / width);
    return motion;
  };
  size_t covered = 0, moved = 0;
  const auto& ids = imageOf(frame, Aov::Id).ids;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == 0) continue;
    ++covered;
    const float *p = &imageOf(frame, Aov::Position).values[3 * i], *m = &imageOf(frame, Aov::Motion).values[4 * i];
    const dvec3 point = eye + dvec3(p[0], p[1], p[2]);
    for (const auto& [camera, motion] : {std::pair{&before, dvec2(m[0], m[1])}, {&after, dvec2(m[2], m[3])}}) {
      const auto expected = motionTo(*camera, point, i);
      if (!expected) {
        EXPECT_EQ(motion, dvec2(0));
        continue;
      }
      // Both interpolate the corners of triangles of tens of meters in floats.
      EXPECT_LE(glm::length(motion - *expected), 4e-3) << i % width << ", " << i / width;
      moved += glm::length(motion) > 0.5;
    }
  }
  EXPECT_GT(covered, ids.size() / 4);
  EXPECT_GT(moved, covered / 4);
}

// The background moves as directions do.
TEST_P(LensMotionTest, OfTheBackgroundFollowsTheRotation) {
  const scene::Scene& scene = hall();
  scene::Camera now = cameraOf(scene, kSize, kSize), before = now;
  now.toWorld = glm::translate(glm::dmat4(1), dvec3(0, 0, 1000));  // sees nothing
  before.toWorld = glm::rotate(now.toWorld, 0.02, dvec3(0, 0, 1));
  now.lens = before.lens = GetParam().lens;
  const uint32_t width = kSize, height = heightOf(GetParam());
  Settings settings = settingsOf(width, height, {Aov::Motion});
  settings.display = false;
  SceneState moment;
  moment.previousCameras = {before};
  moment.nextCameras = {now};
  Renderer renderer(device(), scene, nullptr);
  const output::FrameOutput frame = std::move(renderer.render({&now, 1}, settings, moment).front());
  const scene::LensProjection lens(scene::scaledTo(*now.lens, width, height));
  const glm::dmat4 change = glm::inverse(openCvPose(before, scene, true)) * openCvPose(now, scene, true);
  size_t compared = 0;
  for (size_t i = 0; i < size_t{width} * height; ++i) {
    const dvec2 pixel = dvec2(i % width, i / width) + 0.5;
    const auto ray = lens.unproject(pixel);
    const float* m = &imageOf(frame, Aov::Motion).values[4 * i];
    const auto other = ray ? lens.project(dvec3(change * glm::dvec4(*ray, 0))) : std::nullopt;
    if (!other) continue;
    dvec2 expected = *other - pixel;
    if (now.lens->model == LensModel::Equirectangular) expected.x -= width * std::round(expected.x / width);
    const bool isAtEdge = !lens.project(dvec3(change * glm::dvec4(*ray, 0)) + dvec3(0, 0, -1e-3));
    if (isAtEdge) continue;
    EXPECT_LE(glm::length(dvec2(m[0], m[1]) - expected), 2e-3);
    EXPECT_LE(std::abs(m[2]) + std::abs(m[3]), 1e-3);
    ++compared;
  }
  EXPECT_GT(compared, 100u);
}

// The motion of a pinhole camera to a camera with a lens that bends rays is not a projection by one matrix, and vice
// versa.
TEST_P(LensMotionTest, RejectsNeighborsOfTheOtherKind) {
  const scene::Scene& scene = hall();
  scene::Camera plain = cameraOf(scene, kSize, kSize), pinhole = plain, bent = plain;
  pinhole.lens = scene::Lens{.width = 4, .height = 3, .fx = 4, .fy = 5, .cx = 2, .cy = 1};
  bent.lens = GetParam().lens;
  Settings motion = settingsOf(kSize, heightOf(GetParam()), {Aov::Motion}), temporal = motion, data = motion;
  temporal.aovs = {Aov::Color};
  temporal.aa.temporal = true;
  data.aovs = {Aov::Depth};
  Renderer renderer(device(), scene, nullptr);
  const auto isRejected = [&](const scene::Camera& now, const SceneState& moment, const Settings& settings) {
    try {
      renderer.render({&now, 1}, settings, moment);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      EXPECT_THAT(error.what(), testing::HasSubstr("lens that bends rays")) << error.what();
      return true;
    }
    return false;
  };
  for (const auto& [now, other] : {std::pair{plain, bent}, {pinhole, bent}, {bent, plain}, {bent, pinhole}})
    for (const SceneState& moment : {SceneState{.previousCameras = {other}}, SceneState{.nextCameras = {other}}}) {
      EXPECT_TRUE(isRejected(now, moment, motion));
      EXPECT_TRUE(isRejected(now, moment, temporal));
      EXPECT_FALSE(isRejected(now, moment, data));
    }
}

INSTANTIATE_TEST_SUITE_P(Lenses, LensMotionTest, testing::ValuesIn(kLenses),
                         [](const auto& info) { return std::string(info.param.name); });

class LensSamplesTest : public RenderTest {
 protected:
  static std::vector<float> color(const AntiAliasing& aa) {
    const scene::Scene& scene = hall();
    scene::Camera camera = cameraOf(scene, kSize, kSize);
    camera.lens = kLenses[2].lens;
    Settings settings = settingsOf(kSize, kSize, {Aov::Color});
    settings.aa = aa;
    Renderer renderer(device(), scene, nullptr);
    return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
  }
  static double meanDifference(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
    return sum / double(a.size());
  }
};

TEST_F(LensSamplesTest, MultisamplingIsSupersampling) {
  EXPECT_EQ(color({.samples = 4}), color({.superSampling = 2}));
  EXPECT_EQ(color({.samples = 8}), color({.superSampling = 3}));
}

// The first frame of TAA averages its samples, so it is nearer to many samples than one sample is.
TEST_F(LensSamplesTest, TemporalAntiAliasingConverges) {
  const std::vector<float> many = color({.superSampling = 8});
  EXPECT_LT(meanDifference(color({.temporal = true}), many), 0.5 * meanDifference(color({}), many));
}

}  // namespace
}  // namespace latelight::render::test
