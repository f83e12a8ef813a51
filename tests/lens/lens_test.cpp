// Pictures through lenses compared with an independent ray caster: the surface that each pixel's own ray hits, with the
// rays of scene::LensProjection, which tests/scene checks.
//
// A pixel is *steady* if the rays through its center, corners and sides hit one part, at distances within 5 % of each
// other. Other pixels are at an edge, where rounding may select another triangle than the caster does.
#include <fmt/core.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "models/models.h"
#include "render/reference_caster.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "test_device.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using output::Aov;
using scene::LensModel;

class LensPictureTest : public RenderTest {};

struct Picture {
  const char* name;
  scene::Lens lens;
  uint32_t width, height;
};

// The first is rendered like any pinhole view, whose vertices lie on a grid of 1/256 pixel.
const Picture kPictures[] = {
    {"pinhole", {LensModel::Pinhole, 161, 121, 150, 110, 70, 66}, 161, 121},
    {"opencv", {LensModel::OpenCv, 161, 121, 110, 112, 82, 57, {-0.28, 0.07, 1.2e-3, -8e-4, -0.005}}, 161, 121},
    {"rational",
     {LensModel::OpenCv, 640, 480, 400, 400, 320, 240, {0.9, 0.1, 1e-4, 2e-4, 0.01, 1.2, 0.25, 0.02}},
     160,
     120},
    {"pole", {LensModel::OpenCv, 161, 121, 110, 112, 82, 57, {-0.05, 0.01, 1e-3, -5e-4, 0, -0.5, 0, 0}}, 161, 121},
    {"fisheye", {LensModel::Fisheye, 151, 151, 40, 40, 75, 76, {-0.03, 0.012, -0.004, 0.0007}}, 151, 151},
    {"ftheta", {LensModel::FTheta, 151, 151, 1, 1, 75, 76, {0, 0.025, 2e-5, -3e-7}}, 151, 151},
    {"equirectangular", {.model = LensModel::Equirectangular}, 201, 101},
    {"cubemap", {.model = LensModel::CubeMap}, 384, 64},
};

// The comparison of one pixel.
struct Share {
  size_t pixels = 0, covered = 0, steady = 0;
  size_t parts = 0, steadyParts = 0;  // number of pixels with a different part
  size_t depths = 0, normals = 0;     // number of pixels with the same part, but beyond the tolerance
  double distance = 0, depth = 0, position = 0, uv = 0;  // maximum errors of steady pixels

  void merge(const Share& s) {
    pixels += s.pixels, covered += s.covered, steady += s.steady, parts += s.parts, steadyParts += s.steadyParts;
    depths += s.depths, normals += s.normals;
    distance = std::max(distance, s.distance), depth = std::max(depth, s.depth);
    position = std::max(position, s.position), uv = std::max(uv, s.uv);
  }
};

class Comparison {
 public:
  Comparison(vk::Device& device, const scene::Scene& scene, scene::Camera camera, const Picture& picture)
      : picture_(picture),
        projection_(scene::scaledTo(picture.lens, picture.width, picture.height)),
        caster_(scene, camera, picture.width, picture.height) {
    camera.lens = picture.lens;
    Settings settings = settingsOf(picture.width, picture.height,
                                   {Aov::Depth, Aov::Distance, Aov::Position, Aov::GeoNormal, Aov::Uv, Aov::Part});
    settings.axes = Axes::ZUp;
    frame_ = renderOne(device, scene, camera, settings);
  }

  Share run() const {
    std::vector<Share> rows(picture_.height);
    parallelFor(picture_.height, 8, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y)
        for (uint32_t x = 0; x < picture_.width; ++x) compare(x, static_cast<uint32_t>(y), rows[y]);
    });
    Share all;
    for (const Share& row : rows) all.merge(row);
    return all;
  }

 private:
  std::optional<Hit> cast(dvec2 pixel) const {
    const std::optional<dvec3> ray = projection_.unproject(pixel);
    if (!ray) return std::nullopt;
    return caster_.castAlong({ray->x, ray->z, -ray->y});
  }

  bool isSteady(dvec2 center, const std::optional<Hit>& hit) const {
    for (int i = 0; i < 9; ++i) {
      const std::optional<Hit> other = cast(center + 0.5 * dvec2(i % 3 - 1, i / 3 - 1));
      if (other.has_value() != hit.has_value()) return false;
      if (hit && (other->part != hit->part || std::abs(other->distance / hit->distance - 1) > 0.05)) return false;
    }
    return true;
  }

  void compare(uint32_t x, uint32_t y, Share& share) const {
    const size_t pixel = size_t{y} * picture_.width + x;
    const dvec2 center(x + 0.5, y + 0.5);
    const std::optional<Hit> hit = cast(center);
    const bool steady = isSteady(center, hit);
    const uint32_t part = imageOf(frame_, Aov::Part).ids[pixel];
    ++share.pixels;
    share.covered += hit.has_value();
    share.steady += steady;
    if (part != (hit ? hit->part : 0)) {
      ++share.parts;
      share.steadyParts += steady;
      return;
    }
    if (!hit) {
      EXPECT_TRUE(std::isinf(imageOf(frame_, Aov::Distance).values[pixel]));
      return;
    }
    const double distance = std::abs(imageOf(frame_, Aov::Distance).values[pixel] / hit->distance - 1);
    const double depth = projection_.depthOf(*projection_.unproject(center)) * hit->distance;
    const double depthError = std::abs(imageOf(frame_, Aov::Depth).values[pixel] - depth) / hit->distance;
    const double position =
        glm::length(dvec3(vec3At(imageOf(frame_, Aov::Position), pixel)) - hit->position) / hit->distance;
    const double normal = glm::length(dvec3(vec3At(imageOf(frame_, Aov::GeoNormal), pixel)) - hit->geonormal);
    if (std::max({distance, depthError, position}) > 1e-4) {
      share.depths += steady;
      return;
    }
    if (normal > 1e-3) {
      share.normals += steady;
      return;
    }
    if (!steady) return;
    share.distance = std::max(share.distance, distance), share.depth = std::max(share.depth, depthError);
    share.position = std::max(share.position, position);
    share.uv = std::max(share.uv, glm::length(dvec2(vec2At(imageOf(frame_, Aov::Uv), pixel)) - hit->uv));
  }

  const Picture& picture_;
  scene::LensProjection projection_;
  ReferenceCaster caster_;
  output::FrameOutput frame_;
};

// Prints and checks the measured errors. `edges` is the allowed share of covered pixels with a different part, all of
// which must be at edges.
void expectAsRaysSee(vk::Device& device, const std::string& name, const scene::Scene& scene,
                     const scene::Camera& camera) {
  for (const Picture& picture : kPictures) {
    const Share s = Comparison(device, scene, camera, picture).run();
    fmt::print(
        "{} {}: {} pixels, {} seen, {} steady; other part {}, of them steady {}; steady beyond 1e-4 {}, other triangle "
        "{}; "
        "largest distance {:.2g}, depth {:.2g}, position {:.2g}, uv {:.2g}\n",
        name, picture.name, s.pixels, s.covered, s.steady, s.parts, s.steadyParts, s.depths, s.normals, s.distance,
        s.depth, s.position, s.uv);
    SCOPED_TRACE(name + " " + picture.name);
    const bool drawn = picture.lens.model == LensModel::Pinhole;
    EXPECT_EQ(s.steadyParts, 0u);
    // GPUs interpolate from vertices on the grid, which shows on surfaces at grazing angles.
    EXPECT_LE(double(s.depths), (drawn && !device.isCpu() ? 5e-3 : 0) * double(s.steady));
    EXPECT_LE(double(s.parts), (drawn ? 5e-3 : 1e-3) * double(s.covered));
    EXPECT_LE(double(s.normals), 2e-3 * double(s.steady));
    EXPECT_GT(s.steady, 0u);
  }
}

TEST_F(LensPictureTest, HallAsRaysSeeIt) {
  expectAsRaysSee(device(), "hall", hall(), cameraOf(hall(), 160, 120));
}

TEST_F(LensPictureTest, SpheresAsRaysSeeThem) {
  const scene::Scene spheres = scene::load("builtin:spheres");
  scene::Camera camera = cameraOf(spheres, 160, 120);
  expectAsRaysSee(device(), "spheres", spheres, camera);
  camera.toWorld[3] = glm::vec4(spheres.instances.front().toWorld[3]);  // at the center of a sphere
  expectAsRaysSee(device(), "inside a sphere", spheres, camera);
}

TEST_F(LensPictureTest, ModelsAsRaysSeeThem) {
  for (const std::string& name : models::withReal({}, {"DamagedHelmet.glb"})) {
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    expectAsRaysSee(device(), name, scene, cameraOf(scene, 160, 120));
  }
}

// Squares all around the camera: single- and double-sided, mirrored, and alpha-masked with holes. Their texels are so
// large that level 0 of the texture is sampled. In units of `scale` meters.
scene::Scene squaresAround(float scale) {
  scene::SceneBuilder builder("squares");
  scene::Scene& scene = builder.scene;
  addSquareOfFourKinds(scene);
  for (uint32_t i = 0; i < 60; ++i) {
    const float turn = 0.77f * static_cast<float>(i), up = 0.9f * std::sin(1.3f * static_cast<float>(i));
    const float away = 4 + 0.1f * static_cast<float>(i), mirror = i & 4 ? -1.3f : 0.8f;
    glm::mat4 local(scale);
    local[0] = glm::vec4(mirror * std::cos(turn), 0.2f, -std::sin(turn), 0) * scale;
    local[1] = glm::vec4(0.1f, 1.1f, 0.3f, 0) * scale;
    local[2] = glm::vec4(std::sin(turn), 0, std::cos(turn), 0) * scale;
    local[3] = glm::vec4(away * scale * glm::vec3(std::cos(2.4f * i), 2 * up, std::sin(2.4f * i)), 1);
    builder.addInstance("square", builder.kRoot, 0, i % 4, local);
  }
  return std::move(builder.scene);
}

TEST_F(LensPictureTest, SquaresAllAroundNearAndFar) {
  scene::Camera camera = frontPerspective(0.6f, 0);
  camera.nearClip = scene::kNearClip;
  for (const float scale : {1e-3f, 1e5f})
    expectAsRaysSee(device(), fmt::format("squares of {:g} m", scale), squaresAround(scale), camera);
}

// --- light ----------------------------------------------------------------------------------------------------------

output::AovImage colorOf(vk::Device& device, const scene::Scene& scene, scene::Camera camera, const scene::Lens& lens,
                         Settings settings, const scene::Environment* environment) {
  camera.lens = lens;
  settings.aovs = {Aov::Color};
  return imageOf(renderOne(device, scene, camera, settings, environment), Aov::Color);
}

// The share of pixels that differ by more than 1 % of white, or of their own value.
double shareThatDiffers(const output::AovImage& a, const output::AovImage& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.values.size(); i += 4) {
    bool differs = false;
    for (size_t k = i; k < i + 4; ++k)
      differs |= !(std::abs(a.values[k] - b.values[k]) <= 0.01f * std::max(1.0f, std::abs(a.values[k])));
    count += differs;
  }
  return 4.0 * double(count) / double(a.values.size());
}

// A lens without distortion shows what a pinhole camera does, which other tests check, including shadows, fog, glass,
// masks and the environment. Shadow maps are fitted to a slightly wider view, so their edges move.
TEST_F(LensPictureTest, WithoutDistortionItIsAPinhole) {
  const scene::Environment environment = constantEnvironment();
  for (const char* name : {"punctual.glb", "textured.glb", "blended.glb"}) {
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    const scene::Camera camera = cameraOf(scene, 160, 120);
    Settings settings = settingsOf(160, 120);
    settings.raster = Raster::Compute;
    settings.layout = &findLayout("exact");
    settings.shadows = ShadowFormat::D16;
    // Masked surfaces cast shadows, too.
    if (scene.lights.empty()) settings.sun = SunLight{.azimuth = 0.5f, .elevation = 0.8f};
    settings.fogDensity = 0.05f;
    settings.background.kind = Background::Environment;
    scene::Lens lens{LensModel::Pinhole, 160, 120, 170, 160, 75, 63};
    if (camera.orthographic) continue;
    const output::AovImage pinhole = colorOf(device(), scene, camera, lens, settings, &environment);
    lens.model = LensModel::OpenCv;
    const double share = shareThatDiffers(pinhole, colorOf(device(), scene, camera, lens, settings, &environment));
    fmt::print("{}: {:.2g} of the pixels differ\n", name, share);
    EXPECT_LE(share, 0.01) << name;
  }
}

// The light lists of tiles contain every light that reaches them, for all directions of rays.
TEST_F(LensPictureTest, EveryLightingGivesTheSamePicture) {
  Settings settings = settingsOf(128, 64);
  const scene::Lens lens{.model = LensModel::Equirectangular};
  const scene::Camera camera = cameraOf(hall(), 128, 64);
  const output::AovImage all = colorOf(device(), hall(), camera, lens, settings, nullptr);
  for (const char* lighting : {"tiled", "clustered"}) {
    settings.lighting = &findTechnique(lighting);
    EXPECT_EQ(shareThatDiffers(all, colorOf(device(), hall(), camera, lens, settings, nullptr)), 0) << lighting;
  }
}

// Two lenses see the same light in the same direction, whichever part of the sphere they cover.
TEST_F(LensPictureTest, TheSameLightInEachModel) {
  Settings settings = settingsOf(64, 64);
  settings.shadows = ShadowFormat::D16;
  const scene::Camera camera = cameraOf(hall(), 64, 64);
  const auto ahead = [&](const scene::Lens& lens, uint32_t width, uint32_t height, uint32_t x, uint32_t y) {
    Settings s = settings;
    s.width = width, s.height = height;
    const output::AovImage color = colorOf(device(), hall(), camera, lens, s, nullptr);
    const float* pixel = &color.values[4 * (size_t{y} * width + x)];
    return glm::vec3(pixel[0], pixel[1], pixel[2]);
  };
  const glm::vec3 pinhole = ahead({LensModel::Pinhole, 65, 65, 60, 60, 32.5, 32.5}, 65, 65, 32, 32);
  const glm::vec3 fisheye = ahead({LensModel::Fisheye, 65, 65, 60, 60, 32.5, 32.5}, 65, 65, 32, 32);
  const glm::vec3 cube = ahead({.model = LensModel::CubeMap}, 6 * 65, 65, 4 * 65 + 32, 32);
  const glm::vec3 sphere = ahead({.model = LensModel::Equirectangular}, 129, 65, 64, 32);
  for (const glm::vec3 other : {fisheye, cube, sphere})
    EXPECT_LT(glm::length(other - pinhole), 0.02f * glm::length(pinhole)) << other.x << ' ' << pinhole.x;
}

// --- interface ------------------------------------------------------------------------------------------------------

TEST_F(LensPictureTest, OutsideOfItsCircleALensSeesNothing) {
  scene::Camera camera = frontPerspective(0.6f, 4);
  camera.lens = scene::Lens{LensModel::Fisheye, 64, 64, 10, 10, 32, 32};
  Settings settings = settingsOf(64, 64, {Aov::Color, Aov::Depth});
  settings.background.kind = Background::Environment;
  const scene::Environment environment = constantEnvironment();
  const output::FrameOutput frame = renderOne(device(), squaresAround(1), camera, settings, &environment);
  const scene::LensProjection projection(*camera.lens);
  for (uint32_t i = 0; i < 64 * 64; ++i) {
    const bool sees = projection.unproject({i % 64 + 0.5, i / 64 + 0.5}).has_value();
    EXPECT_EQ(imageOf(frame, Aov::Color).values[4 * i + 3], sees ? 1.0f : 0.0f) << i;
    EXPECT_TRUE(sees || std::isinf(imageOf(frame, Aov::Depth).values[i])) << i;
  }
}

TEST_F(LensPictureTest, ManyAtOnceAndInStripsAreTheSameBytes) {
  std::vector<scene::Camera> cameras(3, cameraOf(hall(), 64, 136));
  for (size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].lens = i < 2 ? scene::Lens{.model = LensModel::Equirectangular} : kPictures[1].lens;
    cameras[i].toWorld[3].x += 0.1f * static_cast<float>(i);
  }
  Settings settings = settingsOf(64, 136, {Aov::Color, Aov::Depth, Aov::Position, Aov::Part, Aov::Uv});
  Renderer renderer(device(), hall(), nullptr);
  const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
  settings.stripPixels = 64 * 64;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const output::FrameOutput alone = renderer.render({&cameras[i], 1}, settings).front();
    for (size_t aov = 0; aov < alone.aovs.size(); ++aov) {
      EXPECT_EQ(alone.aovs[aov].values, together[i].aovs[aov].values) << i << ' ' << aov;
      EXPECT_EQ(alone.aovs[aov].ids, together[i].aovs[aov].ids) << i;
    }
  }
}

// The public API supports the same lenses.
TEST_F(LensPictureTest, AsProgramsAskForThem) {
  const latelight::Scene boxes("builtin:boxes");
  latelight::Renderer renderer(boxes, latelight::test::testDevice());
  latelight::Camera camera = boxes.cameras().front();
  camera.lens = latelight::Lens{latelight::LensModel::Fisheye, 96, 96, 20, 20, 48, 48, {-0.03, 0.012}};
  latelight::Options options;
  options.width = options.height = 48;  // half of the size for which the lens is calibrated
  options.aovs = {"distance"};
  const latelight::Frame frame = renderer.render(camera, options);

  const scene::Scene scene = scene::load("builtin:boxes");
  const ReferenceCaster caster(scene, scene.cameras.front(), 48, 48);
  const scene::LensProjection projection({LensModel::Fisheye, 48, 48, 10, 10, 24, 24, {-0.03, 0.012}});
  for (const uint32_t pixel : {24u * 48 + 24, 30u * 48 + 10, 28u * 48 + 31}) {
    const dvec3 ray = projection.unproject({pixel % 48 + 0.5, pixel / 48 + 0.5}).value();
    const std::optional<Hit> hit = caster.castAlong({ray.x, ray.z, -ray.y});
    const float distance = frame.aovs.at("distance").values[pixel];
    ASSERT_TRUE(hit) << pixel;
    EXPECT_NEAR(distance, hit->distance, 1e-4 * hit->distance);
  }
  camera.lens->distortion[1] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(renderer.render(camera, options), latelight::Error);
  camera.lens = latelight::Lens{.fx = -1, .fy = 1};
  EXPECT_THROW(renderer.render(camera, options), latelight::Error);
}

TEST_F(LensPictureTest, WhatThereIsNot) {
  scene::Camera camera = cameraOf(hall(), 64, 64), pinhole = camera;
  camera.lens = scene::Lens{.model = LensModel::Equirectangular};
  Renderer renderer(device(), hall(), nullptr);
  const auto refuses = [&](auto&& change) {
    Settings settings = settingsOf(64, 64, {Aov::Color});
    change(settings);
    EXPECT_THROW(renderer.render({&camera, 1}, settings), Error);
  };
  refuses([](Settings& s) { s.aovs = {Aov::RasterClasses}; });
  refuses([](Settings& s) { s.lighting = &findTechnique("forward"); });
  camera.lens = scene::Lens{.model = LensModel::CubeMap};
  refuses([](Settings&) {});
  camera.lens->model = LensModel::Equirectangular;
  const scene::Camera both[] = {camera, pinhole};
  EXPECT_THROW(renderer.render(both, settingsOf(64, 64)), Error);
}

}  // namespace
}  // namespace latelight::render::test
