// Pictures that take time or have an aperture, against closed forms: the ramp of an edge that moves, the profile of an
// edge out of focus, and the slant of an edge that moves while rows are read out; and against the mean of instants.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "base/error.h"
#include "motion/files.h"
#include "render/exposure/camera_motion.h"
#include "render/exposure/camera_samples.h"
#include "render/exposure/thin_lens.h"
#include "render/frame/view.h"
#include "render/submit/session.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kWidth = 64, kHeight = 48;
constexpr double kFps = 24;

// A white unlit half plane of glTF's frame: x <= `edge` at z = 0.
scene::Scene halfPlane(float edge = 0) {
  scene::SceneBuilder builder("half");
  builder.scene.meshes.push_back(squareMesh());
  scene::Material material = scene::plainMaterial("white", glm::vec3(1), 0, 1);
  material.data.flags |= shared::kMaterialUnlit;
  builder.scene.materials.push_back(material);
  glm::mat4 place = glm::translate(glm::mat4(1), glm::vec3(edge - 50, 0, 0));
  place = glm::scale(place, glm::vec3(50, 50, 1));
  builder.addInstance("plane", scene::SceneBuilder::kRoot, 0, 0, place);
  return std::move(builder.scene);
}

// The same camera, moved along the scene's X axis.
scene::Camera moved(const scene::Camera& camera, double x) {
  scene::Camera other = camera;
  other.toWorld = glm::translate(glm::dmat4(1), glm::dvec3(x, 0, 0)) * camera.toWorld;
  return other;
}

class ExposureTest : public RenderTest, public testing::WithParamInterface<Raster> {
 protected:
  static Settings picture(uint32_t samples) {
    Settings s = settingsOf(kWidth, kHeight, {Aov::Color});
    s.framesPerSecond = kFps;
    s.cameraSamples = samples;
    if (testing::UnitTest::GetInstance()->current_test_info()->value_param()) s.raster = GetParam();
    return s;
  }

  static output::FrameOutput render(const scene::Scene& scene, const scene::Camera& camera, const Settings& settings,
                                    const SceneState& moment = {}) {
    Renderer renderer(device(), scene, nullptr);
    return std::move(renderer.render({&camera, 1}, settings, moment).front());
  }

  // Red and alpha of a column of the picture, in a row.
  static glm::vec2 at(const output::FrameOutput& frame, uint32_t x, uint32_t y) {
    const float* pixel = &imageOf(frame, Aov::Color).values[4 * (size_t{y} * kWidth + x)];
    return {pixel[0], pixel[3]};
  }
};

// --- samples --------------------------------------------------------------------------------------------------------

// The mean of a polynomial over the aperture converges to its integral: that of x^2 over the unit disk is 1/4, over the
// square with corners at distance 1 it is 1/6.
TEST(ExposureSamples, FillTheAperture) {
  for (const auto& [blades, expected] : {std::pair{0u, 1.0 / 4}, {4u, 1.0 / 6}, {6u, 5.0 / 24}}) {
    Settings s;
    s.apertureBlades = blades;
    s.cameraSamples = 4096;
    s.aa.superSampling = 3;
    const std::vector<CameraSample> samples = exposureSamples(s);
    ASSERT_EQ(samples.size(), 4104u);  // a multiple of 9
    glm::dvec2 mean(0), squares(0);
    for (const CameraSample& sample : samples) {
      EXPECT_LE(glm::length(sample.lens), 1 + 1e-12);
      mean += sample.lens / double(samples.size());
      squares += sample.lens * sample.lens / double(samples.size());
    }
    EXPECT_LE(glm::length(mean), 2e-3) << blades;
    EXPECT_NEAR(squares.x, expected, 2e-3) << blades;
    EXPECT_NEAR(squares.y, expected, 2e-3) << blades;
  }
}

// Every part of a pixel is sampled equally often, and at times and places of the aperture that do not depend on it.
TEST(ExposureSamples, DoNotCorrelate) {
  Settings s;
  s.shutter = 2;
  s.cameraSamples = 1024;
  s.aa.superSampling = 4;
  const std::vector<CameraSample> samples = exposureSamples(s);
  std::map<std::pair<float, float>, std::vector<CameraSample>> cells;
  for (const CameraSample& sample : samples) cells[{sample.jitter.x, sample.jitter.y}].push_back(sample);
  ASSERT_EQ(cells.size(), 16u);
  for (const auto& [cell, some] : cells) {
    ASSERT_EQ(some.size(), 64u);
    double seconds = 0;
    glm::dvec2 lens(0);
    for (const CameraSample& sample : some) seconds += sample.seconds / 64, lens += sample.lens / 64.0;
    EXPECT_NEAR(seconds, 0, 0.05);
    EXPECT_LE(glm::length(lens), 0.1);
  }
  EXPECT_DOUBLE_EQ(samples.front().seconds, -1 + 1.0 / 1024);
  EXPECT_DOUBLE_EQ(samples.back().seconds, 1 - 1.0 / 1024);
}

// --- motion blur ----------------------------------------------------------------------------------------------------

// An edge that moves by 12 pixels during the exposure is a ramp of that width.
TEST_P(ExposureTest, AMovingEdgeIsARamp) {
  constexpr uint32_t kSamples = 48;
  constexpr double kPixels = 12, kShutter = 0.5 / kFps;
  const scene::Camera camera = frontCamera(1, 4);   // 48 rows show 2 m
  const double step = 2 * kPixels * 2.0 / kHeight;  // per frame, twice what moves during half a frame
  Settings s = picture(kSamples);
  s.shutter = kShutter;
  SceneState moment;
  moment.previousCameras = {moved(camera, step)};  // so that the plane moves to the right in the picture
  moment.nextCameras = {moved(camera, -step)};
  const output::FrameOutput frame = render(halfPlane(), camera, s, moment);
  for (uint32_t x = 0; x < kWidth; ++x) {
    const double from = x + 0.5 - kWidth * 0.5;  // the edge is there at the middle of the exposure
    const double covered = std::clamp(0.5 - from / kPixels, 0.0, 1.0);
    for (const uint32_t y : {0u, kHeight / 2, kHeight - 1}) {
      EXPECT_NEAR(at(frame, x, y).x, covered, 1.01 / kSamples) << x;
      EXPECT_NEAR(at(frame, x, y).y, covered, 1.01 / kSamples) << x;
    }
  }
}

// With supersampling, a shutter that sees nothing move changes nothing, and data are those of the middle.
TEST_P(ExposureTest, DataAreThoseOfTheMiddle) {
  const scene::Scene scene = movingBox().load();
  const scene::Camera camera = frontPerspective(0.9f, 5);
  Settings s = picture(8);
  s.aovs = {Aov::Color, Aov::Depth, Aov::Normal, Aov::Id, Aov::Motion, Aov::LightsUsed};
  s.time = 0.5;
  SceneState moment{.poses = posesAt(scene, s), .motion = motionNear(scene, s)};
  moment.previousCameras = {moved(camera, -0.1)};
  moment.nextCameras = {moved(camera, 0.1)};
  const output::FrameOutput instant = render(scene, camera, s, moment);
  s.shutter = 0.7 / kFps;
  s.aperture.radius = 0.1;
  const output::FrameOutput exposed = render(scene, camera, s, moment);
  for (const Aov aov : s.aovs) {
    if (aov == Aov::Color) continue;
    EXPECT_EQ(imageOf(instant, aov).values, imageOf(exposed, aov).values) << output::info(aov).name;
    EXPECT_EQ(imageOf(instant, aov).ids, imageOf(exposed, aov).ids) << output::info(aov).name;
  }
  EXPECT_NE(imageOf(instant, Aov::Color).values, imageOf(exposed, Aov::Color).values);
}

// Rotating objects, skins, morph targets and a turning camera: each picture is the mean of instants that are rendered
// by themselves.
TEST_P(ExposureTest, AnimationsAreTheMeanOfInstants) {
  const auto strip = bendingStrip(), square = morphingSquare(), box = movingBox();
  for (const auto* file : {&strip, &square, &box}) {
    const scene::Scene scene = file->load();
    scene::Camera camera = frontPerspective(0.9f, 5);
    Settings s = picture(8);
    s.sun = SunLight{0.5f, 0.6f, 3};
    s.shadows = file == &box ? ShadowFormat::D32 : ShadowFormat::None;
    s.time = 0.5;
    s.shutter = 0.2;
    SceneState moment{.poses = posesAt(scene, s), .motion = motionNear(scene, s)};
    scene::Camera next = camera;
    next.toWorld = glm::rotate(camera.toWorld, 0.02, glm::dvec3(0, 0, 1));
    moment.previousCameras = {between(camera, next, -1, kWidth, kHeight)};
    moment.nextCameras = {next};
    const output::FrameOutput exposed = render(scene, camera, s, moment);
    const uint32_t instants = 8;
    std::vector<double> mean(imageOf(exposed, Aov::Color).values.size());
    Renderer renderer(device(), scene, nullptr);
    for (uint32_t i = 0; i < instants; ++i) {
      const double seconds = ((i + 0.5) / instants - 0.5) * s.shutter;
      Settings instant = s;
      instant.shutter = 0;
      *instant.time += seconds;
      scene::Camera here = camera;
      here.toWorld = glm::rotate(camera.toWorld, 0.02 * seconds * kFps, glm::dvec3(0, 0, 1));
      const auto frame = std::move(renderer.render({&here, 1}, instant, {.poses = posesAt(scene, instant)}).front());
      for (size_t k = 0; k < mean.size(); ++k) mean[k] += imageOf(frame, Aov::Color).values[k] / instants;
    }
    double worst = 0;
    for (size_t k = 0; k < mean.size(); ++k)
      worst = std::max(worst, std::abs(mean[k] - imageOf(exposed, Aov::Color).values[k]));
    EXPECT_LE(worst, 2e-3) << scene.name;  // half floats, and poses that round differently by 1e-7
  }
}

// --- depth of field -------------------------------------------------------------------------------------------------

// The share of a disk, or of a square on its corner, of radius 1 that lies below x.
double diskBelow(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return 0.5 + (x * std::sqrt(1 - x * x) + std::asin(x)) / M_PI;
}
double diamondBelow(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return x < 0 ? (1 + x) * (1 + x) / 2 : 1 - (1 - x) * (1 - x) / 2;
}

// Compares the profile of an edge at 4 m with that of its circle of confusion, whose radius is V R |1 / f - 1 / 4 m| in
// half heights.
void expectProfile(const output::FrameOutput& frame, double pixels, double (*below)(double), double within) {
  for (uint32_t x = 0; x < kWidth; ++x) {
    const double expected = below(-(x + 0.5 - kWidth * 0.5) / pixels);
    const float* pixel = &imageOf(frame, Aov::Color).values[4 * (size_t{kHeight / 2} * kWidth + x)];
    EXPECT_NEAR(pixel[0], expected, within) << x;
  }
}

TEST_P(ExposureTest, AnEdgeOutOfFocusHasTheProfileOfTheAperture) {
  const float fov = 0.6f;
  const scene::Camera camera = frontPerspective(fov, 4);
  const scene::Scene scene = halfPlane();
  const double v = 1 / std::tan(0.5 * double{fov});
  for (const double focus : {2.0, 20.0}) {
    Settings s = picture(144);
    s.focusDistance = focus;
    s.aperture.radius = 15 / (kHeight * 0.5 * v * std::abs(1 / focus - 0.25));  // 15 pixels
    if (focus > 4) s.apertureBlades = 4;
    expectProfile(render(scene, camera, s), 15, focus > 4 ? diamondBelow : diskBelow, 0.04);
  }
  Settings sharp = picture(8);
  sharp.focusDistance = 4;
  sharp.aperture.radius = 1;
  expectProfile(render(scene, camera, sharp), 1e-9, diskBelow, 1e-6);
}

// f/2 with a sensor 24 mm high: the focal length is 12 mm / tan(fov / 2), and the diameter half of that.
TEST_P(ExposureTest, FNumbersFollowTheFocalLength) {
  const float fov = 0.05f;
  scene::Camera camera = frontPerspective(fov, 4);
  const double focalLength = 0.012 / std::tan(0.5 * double{fov}), radius = focalLength / 4;
  Settings s = picture(128);
  s.aperture.fNumber = 2;
  s.focusDistance = 6;
  const double pixels = kHeight * 0.5 / std::tan(0.5 * double{fov}) * radius * (1 / 4.0 - 1 / 6.0);
  ASSERT_GT(pixels, 5);
  expectProfile(render(halfPlane(), camera, s), pixels, diskBelow, 0.03);
  // A camera's own values have precedence.
  camera.aperture = scene::Aperture{.radius = 0.5 * radius};
  camera.focusDistance = 3;
  expectProfile(render(halfPlane(), camera, s), pixels * 0.5, diskBelow, 0.03);
}

// The focal length of a lens is its number of pixels per radian at the principal point: with 80 of 120 pixels, 16 mm of
// a sensor 24 mm high, whose aperture at f/4 has a radius of 2 mm.
TEST(ThinLens, HasTheFocalLengthOfTheLens) {
  using scene::LensModel;
  const scene::Lens lenses[] = {
      {.model = LensModel::OpenCv, .distortion = {-0.2, 0.05, 1e-3, 2e-3}},
      {.model = LensModel::Fisheye, .distortion = {-0.03, 0.01}},
      {.model = LensModel::FTheta, .distortion = {0, 1, -0.1}},
      {.model = LensModel::FTheta, .fx = 1, .fy = 1, .distortion = {0, 0.0125, 1e-6}},
      {.model = LensModel::FTheta, .fx = 20, .fy = 20, .distortion = {0.01, 0.25}},
  };
  for (scene::Lens lens : lenses) {
    lens.width = 160, lens.height = 120, lens.cx = 70, lens.cy = 65;
    if (lens.fy == 0) lens.fx = lens.fy = 80;
    scene::Camera camera = frontPerspective(0.6f, 4);
    camera.lens = lens;
    Settings s = settingsOf(320, 240, {Aov::Color});
    s.sensorHeight = 24;
    s.aperture.fNumber = 4;
    EXPECT_NEAR(thinLensOf(camera, s, halfPlane()).radius, 0.002, 1e-9);
    // 80 pixels per radian at the axis, by the projection itself.
    const scene::LensProjection projection(lens);
    const double above = lens.distortion[0] > 0 && lens.model == LensModel::FTheta ? lens.distortion[0] : 0;
    const auto pixel = projection.project({0, std::sin(above + 1e-4), std::cos(above + 1e-4)});
    EXPECT_NEAR(pixel.value().y - lens.cy, 80 * 1e-4, 1e-5);
  }
}

// A lens without distortion blurs as a pinhole projection with an aperture does.
TEST_F(ExposureTest, ALensWithRaysOfItsOwnHasAnAperture) {
  const float fov = 0.6f;
  scene::Camera camera = frontPerspective(fov, 4);
  const double f = kHeight * 0.5 / std::tan(0.5 * double{fov});
  camera.lens = scene::Lens{.model = scene::LensModel::OpenCv,
                            .width = kWidth,
                            .height = kHeight,
                            .fx = f,
                            .fy = f,
                            .cx = kWidth * 0.5,
                            .cy = kHeight * 0.5};
  Settings s = picture(48);
  s.focusDistance = 2;
  s.aperture.radius = 15 / (f * 0.25);
  expectProfile(render(halfPlane(), camera, s), 15, diskBelow, 0.06);
}

// --- rolling shutter ------------------------------------------------------------------------------------------------

// While the camera moves, the edge is slanted: by 20 pixels over all rows.
TEST_P(ExposureTest, AMovingEdgeIsSlantedByTheReadout) {
  constexpr double kPixels = 20;
  const scene::Camera camera = frontCamera(1, 4);
  const double step = 2 * kPixels * 2.0 / kHeight;
  Settings s = picture(1);
  s.aovs = {Aov::Color, Aov::Position, Aov::Id};
  s.readout = 0.5 / kFps;
  SceneState moment;
  moment.previousCameras = {moved(camera, step)};
  moment.nextCameras = {moved(camera, -step)};
  const output::FrameOutput frame = render(halfPlane(), camera, s, moment);
  for (uint32_t y = 0; y < kHeight; ++y) {
    const double shift = ((y + 0.5) / kHeight - 0.5) * kPixels;  // of the plane, to the right
    for (uint32_t x = 0; x < kWidth; ++x) {
      const double from = x + 0.5 - kWidth * 0.5 - shift;
      if (std::abs(from) < 0.01) continue;
      EXPECT_EQ(at(frame, x, y).x, from < 0 ? 1 : 0) << x << "," << y;
      EXPECT_EQ(imageOf(frame, Aov::Id).ids[y * kWidth + x] != 0, from < 0);
      if (from > 0) continue;
      EXPECT_NEAR(vec3At(imageOf(frame, Aov::Position), y * kWidth + x).x, from * 2 / kHeight, 1e-4);
    }
  }
}

// A row of the hall, of a box that moves, with sun and shadows, and through a lens is that row of the picture at the
// instant of the row.
TEST_P(ExposureTest, RowsAreThoseOfTheirInstants) {
  const scene::Scene box = movingBox().load();
  scene::Camera outside = frontPerspective(0.9f, 5), bent = outside;
  bent.lens = scene::Lens{.model = scene::LensModel::OpenCv,
                          .width = kWidth,
                          .height = kHeight,
                          .fx = 50,
                          .fy = 50,
                          .cx = 32,
                          .cy = 24,
                          .distortion = {-0.2, 0.05}};
  const std::tuple<const scene::Scene&, scene::Camera> cases[] = {
      {hall(), cameraOf(hall(), kWidth, kHeight)}, {box, outside}, {box, bent}};
  for (const auto& [scene, camera] : cases) {
    Settings s = picture(1);
    s.aovs = {Aov::Color, Aov::Depth, Aov::Normal, Aov::Id, Aov::Position};
    s.sun = SunLight{0.5f, 0.6f, 3};
    s.shadows = ShadowFormat::D32;
    s.readout = -0.03;
    if (&scene == &box) s.time = 0.5;
    SceneState moment{.poses = posesAt(scene, s), .motion = motionNear(scene, s)};
    scene::Camera next = camera;
    next.toWorld = glm::rotate(camera.toWorld, 0.05, glm::dvec3(0.1, 0.2, 1));
    next.toWorld[3] += glm::dvec4(0.05, 0.02, 0, 0);
    moment.nextCameras = {next};
    moment.previousCameras = {between(camera, next, -1, kWidth, kHeight)};
    const output::FrameOutput rolling = render(scene, camera, s, moment);
    Renderer renderer(device(), scene, nullptr);
    for (const uint32_t y : {0u, 5u, 24u, kHeight - 1}) {
      const double seconds = ((y + 0.5) / kHeight - 0.5) * s.readout;
      Settings instant = s;
      instant.readout = 0;
      if (s.time) *instant.time += seconds;
      const scene::Camera here =
          between(camera, seconds > 0 ? next : moment.previousCameras[0], std::abs(seconds) * kFps, kWidth, kHeight);
      const auto frame = std::move(renderer.render({&here, 1}, instant, {.poses = posesAt(scene, instant)}).front());
      for (const Aov aov : s.aovs) {
        const output::AovImage &one = imageOf(rolling, aov), &other = imageOf(frame, aov);
        const size_t channels = output::info(aov).channels, first = channels * kWidth * y;
        // Texture filters of the graphics pipeline take their derivatives from pairs of rows.
        const float within = aov == Aov::Color && GetParam() == Raster::Hardware ? 0.1f : 2e-3f;
        size_t differing = 0;
        for (size_t i = first; i < first + channels * kWidth; ++i)
          differing += output::holdsIds(aov)
                           ? one.ids[i] != other.ids[i]
                           : !(one.values[i] == other.values[i] ||
                               std::abs(one.values[i] - other.values[i]) <= within * (1 + std::abs(other.values[i])));
        EXPECT_LE(differing, channels) << scene.name << " row " << y << " " << output::info(aov).name;
      }
    }
  }
}

// --- combinations ---------------------------------------------------------------------------------------------------

// All together; several views at once, in strips, and through the display, are what each is by itself.
TEST_P(ExposureTest, ViewsAndStripsDoNotMatter) {
  const scene::Scene scene = movingBox().load();
  const scene::Camera camera = frontPerspective(0.9f, 5);
  for (const double readout : {0.0, 0.02}) {
    Settings s = picture(4);
    s.aovs = {Aov::Color, Aov::Depth};
    s.display = true;
    if (readout == 0) s.time = 0.5;
    s.shutter = 0.03;
    s.readout = readout;
    s.aperture.radius = 0.2;
    s.aa.superSampling = 2;
    const scene::Camera cameras[] = {camera, moved(camera, 0.3)};
    SceneState moment{.poses = posesAt(scene, s), .motion = motionNear(scene, s)};
    moment.previousCameras = {moved(camera, -0.1), moved(camera, 0.2)};
    moment.nextCameras = {moved(camera, 0.1), moved(camera, 0.4)};
    Renderer renderer(device(), scene, nullptr);
    const auto both = renderer.render(cameras, s, moment);
    ASSERT_EQ(both.size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
      SceneState own = moment;
      own.previousCameras = {moment.previousCameras[i]};
      own.nextCameras = {moment.nextCameras[i]};
      const auto one = std::move(renderer.render({&cameras[i], 1}, s, own).front());
      EXPECT_EQ(one.display, both[i].display);
      EXPECT_EQ(imageOf(one, Aov::Color).values, imageOf(both[i], Aov::Color).values);
      EXPECT_EQ(imageOf(one, Aov::Depth).values, imageOf(both[i], Aov::Depth).values);
      if (readout != 0) continue;
      Settings strips = s;
      strips.height = 4 * kHeight;
      Settings whole = strips;
      strips.stripPixels = kWidth * 64;
      EXPECT_EQ(renderer.render({&cameras[i], 1}, strips, own)[0].display,
                renderer.render({&cameras[i], 1}, whole, own)[0].display);
    }
    // The scene is where it was.
    Settings still = picture(1);
    const SceneState rest{.poses = posesAt(scene, s)};
    still.time = s.time;
    EXPECT_EQ(imageOf(renderer.render({&camera, 1}, still, rest)[0], Aov::Color).values,
              imageOf(render(scene, camera, still, rest), Aov::Color).values);
  }
}

INSTANTIATE_TEST_SUITE_P(Rasters, ExposureTest, testing::Values(Raster::Hardware, Raster::Compute),
                         [](const auto& info) { return info.param == Raster::Hardware ? "hardware" : "compute"; });

// --- cameras between frames -----------------------------------------------------------------------------------------

Settings pictureAt(double framesPerSecond) {
  Settings s = settingsOf(kWidth, kHeight, {Aov::Color});
  s.framesPerSecond = framesPerSecond;
  return s;
}

// Returns the scales and the principal point (NDC) of a camera's projection.
glm::vec4 projectionOf(const scene::Camera& camera) {
  const shared::Projection p = makeView(camera, kWidth, kHeight).projection;
  return {p.H, p.V, p.X, p.Z};
}

float fovOf(double focalLengthInHalfHeights) {
  return static_cast<float>(2 * std::atan(1 / focalLengthInHalfHeights));
}

TEST(CameraMotion, IsUniformBetweenFrames) {
  scene::Camera now = frontPerspective(0.5f, 3), next = now;
  next.toWorld = glm::rotate(now.toWorld, 0.4, glm::dvec3(0, 1, 0));
  next.toWorld[3] += glm::dvec4(1, 2, 4, 0);
  const CameraMotion motion({now}, {now}, {next}, {.sincePrevious = {0}, .untilNext = {0.5}}, pictureAt(1));
  for (const double seconds : {-0.25, 0.125, 0.4}) {  // before the first frame, it moves as after it
    const scene::Camera camera = motion.at(0, seconds);
    const glm::dmat4 turned = glm::rotate(now.toWorld, 0.8 * seconds, glm::dvec3(0, 1, 0));
    for (int i = 0; i < 3; ++i) EXPECT_LE(glm::distance(camera.toWorld[i], turned[i]), 1e-12);
    EXPECT_LE(glm::distance(glm::dvec3(camera.toWorld[3] - now.toWorld[3]), glm::dvec3(2, 4, 8) * seconds), 1e-12);
  }
  EXPECT_TRUE(motion.movesCameras());
  EXPECT_FALSE(CameraMotion({now}, {now}, {now}, {}, pictureAt(1)).movesCameras());
}

// A camera can state the projection of a picture of 4:3 by its field of view, by a wider frame of its own, which the
// picture shows all of, or by a lens.
TEST(CameraMotion, MixesProjectionsHoweverTheyAreDescribed) {
  const auto camerasOf = [](double focalLength, glm::vec2 principal) {
    scene::Camera plain = frontPerspective(fovOf(focalLength), 3);
    plain.principal = principal;
    scene::Camera framed = plain;
    framed.aspect = 2.0f;
    framed.verticalFov = fovOf(focalLength * 1.5);
    scene::Camera calibrated = frontPerspective(0.8f, 3);
    const double f = 50 * focalLength;
    calibrated.lens = scene::Lens{.width = 160, .height = 100, .fx = 1.2 * f, .fy = f};
    calibrated.lens->cx = 80 * (1 + double{principal.x});
    calibrated.lens->cy = 50 * (1 - double{principal.y});
    return std::array{plain, framed, calibrated};
  };
  constexpr double kNear = 3, kFar = 5;
  for (const scene::Camera& now : camerasOf(kNear, {0.1, -0.2}))
    for (const scene::Camera& next : camerasOf(kFar, {0.3, 0.2})) {
      const CameraMotion motion({now}, {}, {next}, {}, pictureAt(2));
      EXPECT_TRUE(motion.movesCameras());
      for (const double share : {-0.5, 0.25, 1.0}) {
        const double v = kNear + (kFar - kNear) * share;
        const glm::vec4 expected(v * 0.75, v, 0.1 + 0.2 * share, -0.2 + 0.4 * share);
        EXPECT_LE(glm::length(projectionOf(motion.at(0, 0.5 * share)) - expected), 1e-5) << share;
      }
    }
  for (const scene::Camera& now : camerasOf(kNear, {0.1, -0.2}))
    for (const scene::Camera& next : camerasOf(kNear, {0.1, -0.2}))
      EXPECT_LE(glm::length(projectionOf(CameraMotion({now}, {}, {next}, {}, pictureAt(2)).at(0, 0.2)) -
                            glm::vec4(kNear * 0.75, kNear, 0.1, -0.2)),
                1e-5);
}

TEST(CameraMotion, MixesTheExtentsOfOrthographicCameras) {
  scene::Camera now = frontCamera(1.25f, 4), next = frontCamera(3.0f, 4);
  now.aspect = 2.0f;  // the picture of 4:3 shows 1.5 times the height
  const CameraMotion motion({now}, {}, {next}, {}, pictureAt(2));
  EXPECT_NEAR(projectionOf(motion.at(0, 0.125)).y, 1 / (1.875 + 1.125 * 0.25), 1e-6);
  EXPECT_NEAR(projectionOf(motion.at(0, 0.125)).x, 0.75 / (1.875 + 1.125 * 0.25), 1e-6);
  next.yHalf = 1.875f;
  EXPECT_FALSE(CameraMotion({now}, {}, {next}, {}, pictureAt(2)).movesCameras());
  // There is nothing between a parallel and a perspective projection.
  const scene::Camera perspective = frontPerspective(0.3f, 4);
  EXPECT_EQ(projectionOf(CameraMotion({perspective}, {}, {now}, {}, pictureAt(2)).at(0, 0.2)),
            projectionOf(perspective));
}

// Pinhole lenses zoom and shift, as the field of view and the principal point of cameras without a lens do.
TEST(CameraMotion, ChangesPinholeLenses) {
  scene::Camera now;
  now.lens = scene::Lens{.width = 64, .height = 48, .fx = 50, .fy = 40, .cx = 32, .cy = 24};
  scene::Camera next = now;
  next.lens = scene::Lens{.width = 128, .height = 96, .fx = 120, .fy = 88, .cx = 60, .cy = 52};  // 60, 44, 30, 26
  const CameraMotion motion({now}, {}, {next}, {}, pictureAt(2));
  EXPECT_TRUE(motion.movesCameras());
  for (const double share : {-0.5, 0.25, 1.0}) {
    const scene::Lens lens = motion.at(0, 0.5 * share).lens.value();
    EXPECT_EQ(lens.width, 64);
    EXPECT_EQ(lens.height, 48);
    EXPECT_NEAR(lens.fx, 50 + 10 * share, 1e-12);
    EXPECT_NEAR(lens.fy, 40 + 4 * share, 1e-12);
    EXPECT_NEAR(lens.cx, 32 - 2 * share, 1e-12);
    EXPECT_NEAR(lens.cy, 24 + 2 * share, 1e-12);
  }
  EXPECT_FALSE(CameraMotion({now}, {now}, {now}, {}, pictureAt(2)).movesCameras());
}

// --- errors ---------------------------------------------------------------------------------------------------------

TEST_F(ExposureTest, RejectsWhatItCannotCombine) {
  const scene::Scene scene = halfPlane();
  const scene::Camera camera = frontPerspective(0.6f, 4);
  SceneState moment;
  moment.previousCameras = {moved(camera, -0.1)};
  moment.nextCameras = {moved(camera, 0.1)};
  const auto messageOf = [&](const scene::Camera& from, const std::function<void(Settings&)>& change) -> std::string {
    Settings s = picture(2);
    change(s);
    try {
      render(scene, from, s, moment);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(messageOf(camera, [](Settings& s) { s.readout = 0.1, s.bloom = 0.1f; }), testing::HasSubstr("--bloom"));
  EXPECT_THAT(messageOf(camera, [](Settings& s) { s.readout = 0.1, s.aovs = {Aov::Motion}; }),
              testing::HasSubstr("motion"));
  EXPECT_THAT(messageOf(camera, [](Settings& s) { s.shutter = 0.1, s.aa.temporal = true; }),
              testing::HasSubstr("--aa taa"));
  EXPECT_THAT(messageOf(camera, [](Settings& s) { s.apertureBlades = 2; }), testing::HasSubstr("at least 3"));
  EXPECT_THAT(messageOf(frontCamera(), [](Settings& s) { s.aperture.radius = 0.1; }),
              testing::HasSubstr("orthographic"));
  scene::Camera around = camera;
  around.lens = scene::Lens{.model = scene::LensModel::Equirectangular, .width = 2, .height = 1};
  EXPECT_THAT(messageOf(around, [](Settings& s) { s.aperture.radius = 0.1; }), testing::HasSubstr("equirectangular"));
  for (const char* text : {"f/0", "f/", "-1", "wide", "1e9", "f/nan"})
    EXPECT_THROW(scene::parseAperture("--aperture", text), Error) << text;
}

}  // namespace
}  // namespace latelight::render::test
