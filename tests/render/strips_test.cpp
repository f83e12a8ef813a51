// Images rendered in strips against the same images rendered at once: the boundaries must not be visible.
#include "render/submit/strips.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "render/frame/view.h"
#include "render/submit/picking.h"
#include "render/support.h"
#include "scene/load/load.h"
#include "shared/light.h"
#include "vk/memory.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kStripWidth = 96, kStripHeight = 200;  // strips of 64, 64, 64 and 8 rows
constexpr uint32_t kStripPixels = kStripWidth * 100;
constexpr size_t kHandful = 6;

// A scene with a glass box, lit by three lights that all cast shadows.
scene::Scene litBoxes() {
  scene::Scene scene = scene::load("builtin:boxes");
  scene::Material& glass = scene.materials[3];
  glass.data.flags |= shared::kMaterialBlended;
  glass.data.baseColor.a = 0.5f;
  for (const glm::vec3 position : {glm::vec3(-3, -4, 4), glm::vec3(3, -3, 5)}) {
    scene::Light& light = scene.lights.emplace_back();
    light.name = "lamp";
    light.type = shared::kLightPoint;
    light.position = position;
    light.intensity = 30;
    light.range = 9.0f;
  }
  return scene;
}

Settings stripped(Settings settings) {
  settings.stripPixels = kStripPixels;
  return settings;
}

struct StripCase {
  const char* name;
  void (*change)(Settings&, scene::Camera&);
};
const StripCase kStripCases[] = {
    {"plain", [](Settings&, scene::Camera&) {}},
    {"msaa4OffCenter",
     [](Settings& s, scene::Camera& c) {
       s.aa.samples = 4;
       c.principal = {0.3f, -0.45f};
     }},
    {"msaa8InCompute",
     [](Settings& s, scene::Camera& c) {
       s.raster = Raster::Compute;
       s.aa.samples = 8;
       c.principal = {0.3f, -0.45f};
     }},
    {"superSampledClustered",
     [](Settings& s, scene::Camera&) {
       s.aa.superSampling = 2;
       s.lighting = &findTechnique("clustered");
       s.background.kind = Background::Environment;
     }},
    {"orthographicVolumes",
     [](Settings& s, scene::Camera& c) {
       s.lighting = &findTechnique("volumes");
       s.fogDensity = 0.05f;
       c.orthographic = true;
       c.yHalf = 3;
       c.farClip = 40;
     }},
};

class StripsTest : public RenderTest, public testing::WithParamInterface<StripCase> {};

// The maximum difference of an output's values due to rounding. The projection of a strip rounds differently from that
// of the full image.
struct Tolerance {
  double absolute, relative;
};
// A CPU device clips triangles at the strip's border, and the clipped edge splits the samples of the pixels that it
// crosses. With several samples per pixel, the surface is then shaded at a different point of such a pixel.
Tolerance toleranceOf(Aov aov, uint32_t samples) {
  switch (aov) {
    case Aov::Depth:
    case Aov::Distance:
      return {0, 1e-6};
    case Aov::Position:
      return {1e-5, 1e-6};  // in meters; the camera is about ten meters away
    case Aov::Motion:
      return {1e-3, 0};  // in pixels
    case Aov::Color:
      return samples > 1 ? Tolerance{1e-2, 2e-2} : Tolerance{2e-3, 2e-3};  // half floats
    case Aov::Uv:
      return {1e-5, 0};  // a pixel covers at least 0.02
    default:
      return {2e-6, 0};
  }
}

// Returns the pixels whose values differ by more than rounding explains.
std::vector<bool> unlike(const output::AovImage& a, const output::AovImage& b, uint32_t samples) {
  const size_t pixels = size_t{a.width} * a.height;
  std::vector<bool> differs(pixels);
  for (size_t i = 0; i < a.ids.size(); ++i) differs[i] = a.ids[i] != b.ids[i];
  const Tolerance t = toleranceOf(a.aov, samples);
  for (size_t i = 0; i < a.values.size(); ++i) {
    const double x = a.values[i], y = b.values[i];
    if (x != y && !(std::abs(x - y) <= t.absolute + t.relative * std::abs(y)))
      differs[i / (a.values.size() / pixels)] = true;
  }
  return differs;
}

TEST_P(StripsTest, EqualTheFullImage) {
  const scene::Scene scene = litBoxes();
  const scene::Environment studio = scene::loadEnvironment("studio");
  Settings settings = settingsOf(kStripWidth, kStripHeight);
  settings.display = true;
  settings.shadows = ShadowFormat::D32;
  settings.shadowAtlas = 4096;  // with texels smaller than pixels, so that the edges of shadows are lines
  settings.sun = SunLight{.azimuth = 0.6f, .elevation = 0.8f};
  for (const output::AovInfo& info : output::aovs())
    if (info.aov != output::Aov::RasterClasses &&  // depends on the box of a triangle in its strip
        info.aov != output::Aov::Raw)              // the rounded picture
      settings.aovs.push_back(info.aov);
  scene::Camera camera = scene.cameras.front();
  GetParam().change(settings, camera);
  SceneState moment;
  moment.previousCameras = {camera};
  moment.nextCameras = {camera};
  moment.previousCameras[0].toWorld[3].x -= 0.1f;
  moment.nextCameras[0].toWorld[3].z += 0.2f;

  Renderer renderer(device(), scene, &studio);
  const output::FrameOutput whole = std::move(renderer.render({&camera, 1}, settings, moment).front());
  const output::FrameOutput strips = std::move(renderer.render({&camera, 1}, stripped(settings), moment).front());
  EXPECT_EQ(strips.width, kStripWidth);
  EXPECT_EQ(strips.height, kStripHeight);
  ASSERT_EQ(strips.aovs.size(), whole.aovs.size());
  for (size_t i = 0; i < whole.aovs.size(); ++i) {
    SCOPED_TRACE(output::info(whole.aovs[i].aov).name);
    EXPECT_EQ(strips.aovs[i].height, kStripHeight);
    ASSERT_EQ(strips.aovs[i].values.size(), whole.aovs[i].values.size());
    ASSERT_EQ(strips.aovs[i].ids.size(), whole.aovs[i].ids.size());
    const std::vector<bool> differs = unlike(strips.aovs[i], whole.aovs[i], settings.aa.samples);
    const auto count = static_cast<size_t>(std::count(differs.begin(), differs.end(), true));
    EXPECT_LE(count, kHandful);
  }
  ASSERT_EQ(strips.display.size(), size_t{4} * kStripWidth * kStripHeight);
  ASSERT_EQ(whole.display.size(), strips.display.size());
  size_t apart = 0;
  for (size_t i = 0; i < whole.display.size(); ++i) apart += std::abs(int{whole.display[i]} - strips.display[i]) > 1;
  EXPECT_LE(apart, 4 * kHandful);
}

INSTANTIATE_TEST_SUITE_P(Render, StripsTest, testing::ValuesIn(kStripCases),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_F(RenderTest, PickingFromAStripEqualsPickingFromTheFullImage) {
  const scene::Scene scene = litBoxes();
  Renderer renderer(device(), scene, nullptr);
  const Settings settings = settingsOf(kStripWidth, kStripHeight);
  const std::vector<glm::uvec2> pixels{{48, 199}, {30, 63}, {60, 64}, {48, 130}, {5, 1}};
  const auto whole = pick(renderer, scene, scene.cameras.front(), settings, pixels).picked;
  const auto strips = pick(renderer, scene, scene.cameras.front(), stripped(settings), pixels).picked;
  ASSERT_EQ(strips.size(), pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_EQ(strips[i].pixel, pixels[i]);
    EXPECT_EQ(strips[i].id, whole[i].id);
    EXPECT_EQ(strips[i].node, whole[i].node);
    EXPECT_NEAR(strips[i].depth, whole[i].depth, 1e-6 * whole[i].depth);
  }
  EXPECT_NE(strips[0].id, 0u);
}

// Measures the memory in use after rendering: the image's targets, several of them at once, and their readback buffers.
TEST_F(RenderTest, StripsRequireOnlyAStripsMemory) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const auto usedBytesOf = [&](const Settings& settings) {
    Renderer renderer(device(), scene, nullptr);
    const uint64_t before = device().memory().statistics().usedBytes;
    renderer.render({&scene.cameras.front(), 1}, settings);
    return device().memory().statistics().usedBytes - before;
  };
  Settings settings = settingsOf(512, 512, {Aov::Depth, Aov::Normal});
  settings.display = true;
  const uint64_t whole = usedBytesOf(settings);
  settings.stripPixels = 512 * 64;
  const uint64_t strips = usedBytesOf(settings);  // eight strips
  EXPECT_GT(whole, uint64_t{512} * 512 * 32);
  EXPECT_LT(strips, whole / 6);
}

// In closed form: the ray of a pixel is that of the camera's full image, regardless of the strip that contains the
// pixel.
TEST(Strips, EachPixelKeepsItsRay) {
  scene::Camera camera;
  camera.principal = {0.3f, -0.7f};
  for (const bool orthographic : {false, true}) {
    camera.orthographic = orthographic;
    camera.yHalf = 3;
    camera.farClip = orthographic ? 100.0f : camera.farClip;
    const glm::vec2 jitter(0.25f, -0.375f);
    const shared::View whole = makeView(camera, 1000, 3000, jitter);
    for (const Strip strip : {Strip{0, 64}, Strip{1024, 512}, Strip{2944, 56}}) {
      const shared::View view = viewOf(whole, strip);
      EXPECT_EQ(view.size, glm::vec2(1000, strip.rows));
      for (const uint32_t row : {0u, strip.rows / 2, strip.rows - 1}) {
        const glm::dvec2 pixel(700.5, strip.first + row + 0.5);
        // Half the image's height is 1 / V in the camera's plane at 1 m, and the sample is offset from the pixel's
        // center by the jitter.
        const double half = orthographic ? 3.0 : std::tan(0.5 * double{camera.verticalFov});
        const double x = ((2 * (pixel.x + jitter.x) / 1000 - 1) - camera.principal.x) * half / 3;
        const double z = ((1 - 2 * (pixel.y + jitter.y) / 3000) - camera.principal.y) * half;
        const glm::vec2 ndc = shared::pixelToNdc({700.5f, static_cast<float>(row) + 0.5f}, view.size);
        const glm::vec3 seen = shared::viewPositionAtDepth(view.projection, ndc, 1);
        EXPECT_NEAR(seen.x, x, 1e-6 * half);
        EXPECT_NEAR(seen.z, z, 1e-6 * half);
        const glm::vec4 clip = shared::projectToClip(view.projection, seen);
        EXPECT_NEAR(clip.y / clip.w, ndc.y, 1e-5);
      }
    }
  }
}

TEST(Strips, CoverTheImageOnce) {
  Settings s;
  s.width = 16384;
  s.height = 16383;
  const std::vector<Strip> strips = stripsOf(s);
  EXPECT_GT(strips.size(), 1u);
  uint32_t next = 0;
  for (const Strip strip : strips) {
    EXPECT_EQ(strip.first, next);
    EXPECT_EQ(strip.first % 64, 0u);
    EXPECT_GE(strip.rows, 1u);
    EXPECT_LE(uint64_t{strip.rows} * s.width, s.stripPixels);
    next += strip.rows;
  }
  EXPECT_EQ(next, s.height);
  s.width = 3840;
  s.height = 2160;
  EXPECT_EQ(stripsOf(s).size(), 1u);
}

// Pixels of these effects depend on pixels outside of their strip; data outputs do not.
TEST(Strips, EffectsThatReadNeighborsDisableStrips) {
  Settings large;
  large.width = large.height = 16384;
  for (void (*change)(Settings&) :
       {+[](Settings& s) { s.aa.fxaa = true; }, +[](Settings& s) { s.aa.temporal = true; },
        +[](Settings& s) { s.ambientOcclusion = AmbientOcclusion::Gtao; }, +[](Settings& s) { s.bloom = 0.1f; }}) {
    Settings s = large;
    change(s);
    EXPECT_EQ(stripsOf(s).size(), 1u);
    s.display = false;
    s.aovs = {Aov::Depth};
    EXPECT_GT(stripsOf(s).size(), 1u);
    s.aovs = {Aov::Color};
    EXPECT_EQ(stripsOf(s).size(), 1u);
  }
}

}  // namespace
}  // namespace latelight::render::test
