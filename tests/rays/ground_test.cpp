// The ground that only receives shadows, against closed forms.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "render/lighting/technique.h"
#include "render/options/options.h"
#include "render/support.h"
#include "scene/framing.h"
#include "scene/scene_builder.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

constexpr uint32_t kSize = 48;

// An occluder above the plane z = 0 of the renderer's world.
scene::Scene sceneOf(scene::Mesh occluder, const glm::dmat4& placed) {
  scene::SceneBuilder builder("above");
  builder.scene.meshes.push_back(std::move(occluder));
  scene::Material white = scene::plainMaterial("white", vec3(1), 0, 1);
  white.data.flags |= shared::kMaterialDoubleSided;
  builder.scene.materials.push_back(white);
  builder.addInstance("occluder", builder.kRoot, 0, 0, glm::mat4(1));
  builder.scene.instances[0].toWorld = placed;
  return std::move(builder.scene);
}

glm::dmat4 placedAt(const dvec3& at) {
  glm::dmat4 placed(1);
  placed[3] = glm::dvec4(at, 1);
  return placed;
}

scene::Light sunAlong(const dvec3& direction, float lux = 1) {
  scene::Light light;
  light.type = shared::kLightDirectional;
  light.direction = glm::normalize(direction);
  light.intensity = lux;
  return light;
}

// Looks at the origin from above the plane, 40 degrees down along +Y.
scene::Camera camera(bool orthographic) {
  scene::Camera camera;
  const double down = 40 * 3.14159265358979 / 180;
  const dvec3 forward(0, std::cos(down), -std::sin(down)), up(0, std::sin(down), std::cos(down));
  camera.toWorld[0] = glm::dvec4(1, 0, 0, 0);
  camera.toWorld[1] = glm::dvec4(forward, 0);
  camera.toWorld[2] = glm::dvec4(up, 0);
  camera.toWorld[3] = glm::dvec4(-20.0 * forward, 1);
  camera.orthographic = orthographic;
  camera.yHalf = 4;
  camera.verticalFov = 2 * std::atan(4.0f / 20.0f);
  camera.nearClip = 0.5f;
  if (orthographic) camera.farClip = 100;
  return camera;
}

// The point of the plane z = `height` that a pixel's center shows.
dvec2 groundAt(const scene::Camera& c, uint32_t x, uint32_t y, double height = 0) {
  const dvec2 at(4 * (2 * (x + 0.5) / kSize - 1), 4 * (1 - 2 * (y + 0.5) / kSize));
  const dvec3 across = dvec3(c.toWorld[0]) * at.x + dvec3(c.toWorld[2]) * at.y, eye(c.toWorld[3]), away(c.toWorld[1]);
  const dvec3 from = c.orthographic ? eye + across : eye, along = c.orthographic ? away : away * 20.0 + across;
  const dvec3 hit = from + along * ((height - from.z) / along.z);
  return {hit.x, hit.y};
}

Settings groundSettings(uint32_t samples) {
  Settings settings = settingsOf(kSize, kSize, {Aov::Color, Aov::Depth});
  settings.ground = Ground::Shadow;
  settings.groundHeight = 0;
  settings.samples = samples;
  return settings;
}

// Calls check(ground position, color) for each pixel without a surface.
template <typename Check>
void forGround(const output::FrameOutput& frame, const scene::Camera& camera, Check check) {
  const std::vector<float>&color = imageOf(frame, Aov::Color).values, &depth = imageOf(frame, Aov::Depth).values;
  for (uint32_t i = 0; i < kSize * kSize; ++i)
    if (!(depth[i] > 0 && std::isfinite(depth[i])))
      check(groundAt(camera, i % kSize, i / kSize),
            glm::vec4(color[4 * i], color[4 * i + 1], color[4 * i + 2], color[4 * i + 3]));
}

class GroundTest : public RenderTest {};

// A sphere over a plane under a uniform sky hides R^2 cos(a) / d^2 of the irradiance at a distance d from its center,
// seen at the angle a from the zenith (the form factor of a sphere). The mesh is 2 % smaller than the sphere.
TEST_F(GroundTest, HasTheOcclusionOfASphere) {
  constexpr double kRadius = 1, kHeight = 1.5;
  const scene::Scene scene = sceneOf(sphereMesh(kRadius), placedAt({0, 0, kHeight}));
  const scene::Environment environment = constantEnvironment();
  for (const bool orthographic : {true, false}) {
    const scene::Camera view = camera(orthographic);
    const output::FrameOutput frame = renderOne(device(), scene, view, groundSettings(256), &environment);
    double sum = 0, largest = 0, count = 0, error = 0;
    forGround(frame, view, [&](const dvec2& at, const glm::vec4& color) {
      const double expected = kRadius * kRadius * kHeight / std::pow(glm::dot(at, at) + kHeight * kHeight, 1.5);
      EXPECT_EQ(vec3(color), vec3(0));
      error += (double{color.a} - expected) * (double{color.a} - expected);
      sum += double{color.a} - expected, largest = std::max(largest, expected), ++count;
    });
    EXPECT_GT(largest, 0.2);
    EXPECT_LT(std::sqrt(error / count), 0.02);
    EXPECT_NEAR(sum / count, 0, 0.005);
  }
}

// A square's shadow by a slanting sun is the square, moved along the light.
TEST_F(GroundTest, HasTheShadowOfASun) {
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene.lights.push_back(sunAlong({1, 0.5, -1}));
  const scene::Camera view = camera(true);
  size_t shadowed = 0;
  forGround(renderOne(device(), scene, view, groundSettings(4)), view, [&](const dvec2& at, const glm::vec4& color) {
    const dvec2 from = glm::abs(at - dvec2(2, 1));
    const double edge = std::max(from.x, from.y) - 1;
    if (std::abs(edge) < 1e-3) return;
    EXPECT_EQ(color.a, edge < 0 ? 1.0f : 0.0f) << at.x << " " << at.y;
    shadowed += edge < 0;
  });
  EXPECT_GT(shadowed, 50u);
}

// Two suns that differ by a factor of three in irradiance: each shadow lacks its sun's share.
TEST_F(GroundTest, MeasuresSharesOfAllLights) {
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene.lights = {sunAlong({1, 0, -1}, 3), sunAlong({-1, 0, -1}, 1)};
  const scene::Camera view = camera(true);
  std::array<double, 2> sums{}, counts{};
  forGround(renderOne(device(), scene, view, groundSettings(256)), view, [&](const dvec2& at, const glm::vec4& color) {
    for (int i = 0; i < 2; ++i)
      if (std::max(std::abs(at.x - (i ? -2 : 2)), std::abs(at.y)) < 0.95) sums[i] += double{color.a}, ++counts[i];
  });
  EXPECT_NEAR(sums[0] / counts[0], 0.75, 0.01);
  EXPECT_NEAR(sums[1] / counts[1], 0.25, 0.01);
}

TEST_F(GroundTest, LiesBelowTheLowestVertex) {
  // A square on edge, turned by 45 degrees: its lowest vertex is at 3 - sqrt(2), and its bounds' corners are lower.
  glm::dmat4 turned(1);
  const double r = std::sqrt(0.5);
  turned[0] = glm::dvec4(r, 0, r, 0), turned[1] = glm::dvec4(-r, 0, r, 0), turned[2] = glm::dvec4(0, -1, 0, 0);
  turned[3] = glm::dvec4(0, 0, 3, 1);
  scene::Scene scene = sceneOf(squareMesh(), turned);
  EXPECT_NEAR(scene::lowestPoint(scene), 3 - std::sqrt(2.0), 1e-6);
  scene.lights.push_back(sunAlong({0, 1, -2}));
  Settings automatic = groundSettings(1), given = automatic;
  automatic.groundHeight.reset();
  given.groundHeight = scene::lowestPoint(scene);
  const std::vector<float> found = imageOf(renderOne(device(), scene, camera(false), automatic), Aov::Color).values;
  EXPECT_EQ(found, imageOf(renderOne(device(), scene, camera(false), given), Aov::Color).values);
  EXPECT_NE(found, imageOf(renderOne(device(), scene, camera(false), groundSettings(1)), Aov::Color).values);
}

// Surfaces in the plane and before it hide it, and the plane covers surfaces below it. From below it is not there.
TEST_F(GroundTest, IsSeenFromAboveOnly) {
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene.lights.push_back(sunAlong({0, 0, -1}));
  scene::Camera below = camera(true);
  below.toWorld[1].z *= -1, below.toWorld[2].y *= -1, below.toWorld[3].z *= -1;
  forGround(renderOne(device(), scene, below, groundSettings(1)), below,
            [&](const dvec2&, const glm::vec4& color) { EXPECT_EQ(color.a, 0.0f); });

  scene::Instance floor = scene.instances[0];
  for (const double height : {0.0, -0.5}) {
    SCOPED_TRACE(height);
    scene::Scene both = sceneOf(squareMesh(), placedAt({0, 0, 2}));
    both.lights.push_back(sunAlong({0, 0, -1}));
    floor.toWorld = placedAt({0, 0, height});
    floor.toWorld[0].x = floor.toWorld[1].y = 8;
    floor.id = 99;
    both.instances.push_back(floor);
    const scene::Camera view = camera(true);
    Settings settings = groundSettings(1);
    const std::vector<float> with = imageOf(renderOne(device(), both, view, settings), Aov::Color).values;
    settings.ground = Ground::None;
    const output::FrameOutput without = renderOne(device(), both, view, settings);
    const std::vector<float>& plain = imageOf(without, Aov::Color).values;
    if (height == 0) {
      EXPECT_EQ(with, plain);
      continue;
    }
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
      const dvec2 at = groundAt(view, i % kSize, i / kSize);
      const double edge = std::max(std::abs(at.x), std::abs(at.y)) - 1;
      const dvec3 floorPoint(groundAt(view, i % kSize, i / kSize, height), height);
      const double away = glm::dot(floorPoint - dvec3(view.toWorld[3]), dvec3(view.toWorld[1]));
      const bool floorSeen = std::abs(imageOf(without, Aov::Depth).values[i] - away) < 0.1;
      if (std::abs(edge) < 0.01 || !floorSeen) continue;
      EXPECT_EQ(with[4 * i], edge < 0 ? 0 : plain[4 * i]);
      EXPECT_EQ(with[4 * i + 3], 1);
    }
  }
}

// A fog lies behind the plane, up to infinity: it is seen by the share of the plane that has no shadow.
TEST_F(GroundTest, LiesBeforeFog) {
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene.lights.push_back(sunAlong({0, 0, -1}));
  const scene::Camera view = camera(true);
  Settings settings = groundSettings(1);
  settings.fogDensity = 0.001f;
  settings.fogColor = {0.25f, 0.5f, 1};
  size_t shadows = 0;
  forGround(renderOne(device(), scene, view, settings), view, [&](const dvec2& at, const glm::vec4& color) {
    const double edge = std::max(std::abs(at.x), std::abs(at.y)) - 1;
    if (std::abs(edge) < 0.01) return;
    shadows += edge < 0;
    EXPECT_EQ(color, edge < 0 ? glm::vec4(0, 0, 0, 1) : glm::vec4(0.25f, 0.5f, 1, 1)) << at.x << ' ' << at.y;
  });
  EXPECT_GT(shadows, 50u);
}

// With paths, a blended pane over the plane is part of the picture before the plane is. Its premultiplied color has no
// part of the shadow, and it leaves the plane's alpha the share that it does not cover.
TEST_F(GroundTest, LiesUnderBlendedSurfacesOfPaths) {
  const scene::Camera view = camera(true);
  const scene::Environment environment = constantEnvironment();
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene.lights.push_back(sunAlong({1, 0.5, -1}, 3));
  Settings settings = groundSettings(64), none = settings;
  none.ground = Ground::None;
  const output::FrameOutput ground = renderOne(device(), scene, view, settings, &environment);
  const std::vector<float>&alone = imageOf(ground, Aov::Color).values, &depth = imageOf(ground, Aov::Depth).values;
  scene.materials.push_back(scene::plainMaterial("pane", {0.1f, 0.8f, 0.2f}, 0, 1));
  scene.materials.back().data.flags |= shared::kMaterialBlended | shared::kMaterialDoubleSided;
  scene.materials.back().data.baseColor.a = 0.75f;
  scene::Instance pane = scene.instances[0];
  pane.material = 1, pane.id = 99, pane.toWorld = placedAt({2, 0, 0.5});
  scene.instances.push_back(pane);
  for (const Background::Kind background : {Background::Transparent, Background::Environment})
    for (const char* paths : {"one-bounce", "path", "reference"}) {
      SCOPED_TRACE(fmt::format("{} background {}", paths, int(background)));
      for (Settings* s : {&settings, &none}) {
        s->lighting = &findTechnique(paths == std::string_view("reference") ? "reference" : "fullscreen");
        s->indirect = choiceNamed<Indirect>(paths).value_or(Indirect::None);
        s->background.kind = background;
      }
      const std::vector<float> with =
          imageOf(renderOne(device(), scene, view, settings, &environment), Aov::Color).values;
      none.background.kind = Background::Transparent;
      const std::vector<float> without =
          imageOf(renderOne(device(), scene, view, none, &environment), Aov::Color).values;
      size_t panes = 0;
      for (uint32_t i = 0; i < kSize * kSize; ++i) {
        if (depth[i] > 0 && std::isfinite(depth[i])) continue;
        const float *a = &with[4 * i], *b = &without[4 * i], shadow = alone[4 * i + 3];
        const float rest = (1 - b[3]) * (1 - shadow), sky = background == Background::Environment ? rest : 0;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c] + sky, 2e-3f) << i;
        ASSERT_NEAR(a[3], 1 - rest + sky, 2e-3f) << i;
        panes += b[3] > 0.5f && shadow > 0.1f;
      }
      EXPECT_GT(panes, 50u);
    }
}

TEST_F(GroundTest, WarnsOfAreaLights) {
  scene::Scene scene = sceneOf(squareMesh(), placedAt({0, 0, 2}));
  scene::Light disk;
  disk.type = shared::kLightDisk;
  disk.direction = {0, 0, -1};
  disk.position = {0, 0, 4};
  disk.size = 1;
  disk.intensity = 1;
  scene.lights.push_back(disk);
  for (const Ground ground : {Ground::None, Ground::Shadow}) {
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    Settings settings = groundSettings(1);
    settings.ground = ground;
    renderOne(device(), scene, camera(true), settings);
    const auto isOfGround = [](const std::string& text) { return text.starts_with("--ground ignores area lights"); };
    EXPECT_EQ(std::ranges::count_if(warnings, isOfGround), ground == Ground::Shadow ? 1 : 0);
  }
}

// Data outputs, both rasters, strips, samples and several passes of samples.
TEST_F(GroundTest, WorksWithOtherOptions) {
  const scene::Scene scene = sceneOf(sphereMesh(1), placedAt({0, 0, 1.2}));
  const scene::Environment environment = constantEnvironment();
  const scene::Camera view = camera(false);
  Settings settings = groundSettings(16);
  settings.aovs = {Aov::Color, Aov::Depth, Aov::Id, Aov::Position, Aov::Normal};
  settings.raster = Raster::Compute;
  const output::FrameOutput whole = renderOne(device(), scene, view, settings, &environment);
  Settings strips = settings;
  strips.stripPixels = kSize * 16;
  const output::FrameOutput parts = renderOne(device(), scene, view, strips, &environment);
  Settings hardware = settings;
  hardware.raster = Raster::Hardware;
  const output::FrameOutput drawn = renderOne(device(), scene, view, hardware, &environment);
  Settings none = settings;
  none.ground = Ground::None;
  const output::FrameOutput plain = renderOne(device(), scene, view, none, &environment);
  EXPECT_EQ(imageOf(parts, Aov::Color).values, imageOf(whole, Aov::Color).values);
  for (const Aov aov : {Aov::Depth, Aov::Position, Aov::Normal})
    EXPECT_EQ(imageOf(whole, aov).values, imageOf(plain, aov).values);
  EXPECT_EQ(imageOf(whole, Aov::Id).ids, imageOf(plain, Aov::Id).ids);
  const std::vector<float>&a = imageOf(whole, Aov::Color).values, &b = imageOf(drawn, Aov::Color).values;
  size_t differ = 0;
  for (uint32_t i = 0; i < kSize * kSize; ++i) differ += std::abs(a[4 * i + 3] - b[4 * i + 3]) > 1e-3f;
  EXPECT_LE(differ, 20u);  // the silhouette

  Settings several = settings;  // 150 samples are three passes
  several.samples = 150;
  const output::FrameOutput finer = renderOne(device(), scene, view, several, &environment);
  double mean = 0, expected = 0;
  for (uint32_t i = 0; i < kSize * kSize; ++i)
    mean += double{imageOf(finer, Aov::Color).values[4 * i + 3]}, expected += double{a[4 * i + 3]};
  EXPECT_NEAR(mean / expected, 1, 0.05);

  Settings multisampled = settings;
  multisampled.aa.samples = 4;
  EXPECT_THROW(renderOne(device(), scene, view, multisampled, &environment), Error);
  Settings super = settings;
  super.aa.superSampling = 2;
  EXPECT_NO_THROW(renderOne(device(), scene, view, super, &environment));
}

}  // namespace
}  // namespace latelight::render::test
