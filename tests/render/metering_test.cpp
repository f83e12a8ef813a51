// Automatic exposure: closed forms of the mean, uniform surfaces of any luminance, and pictures that are those of the
// same exposure as a number.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "long_tests.h"
#include "output/metadata.h"
#include "render/submit/metering.h"
#include "render/support.h"
#include "scene/framing.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using output::Aov;

// --- the mean -------------------------------------------------------------------------------------------------------

output::AovImage grays(const std::vector<float>& luminances, float alpha = 1) {
  output::AovImage image{Aov::Color, static_cast<uint32_t>(luminances.size()), 1, {}, {}};
  for (const float y : luminances) image.values.insert(image.values.end(), {alpha * y, alpha * y, alpha * y, alpha});
  return image;
}

std::vector<float> repeated(const std::vector<std::pair<int, float>>& parts) {
  std::vector<float> values;
  for (const auto& [count, value] : parts) values.insert(values.end(), static_cast<size_t>(count), value);
  return values;
}

TEST(Metering, LeavesOutTheTails) {
  // Of 100 pixels, 10 at either end do not count: 20 have luminance 1, and 60 have luminance 4.
  EXPECT_NEAR(meanLogLuminance(grays(repeated({{30, 1}, {70, 4}}))).value(), 1.5, 1e-4);
  EXPECT_NEAR(meanLogLuminance(grays(repeated({{10, 1e-6f}, {80, 4}, {10, 65504}}))).value(), 2, 1e-4);
  EXPECT_NEAR(meanLogLuminance(grays({8})).value(), 3, 1e-4);
}

TEST(Metering, WeighsChannelsAsLuminance) {
  output::AovImage green{Aov::Color, 1, 1, {0, 1, 0, 1}, {}};
  EXPECT_NEAR(meanLogLuminance(green).value(), std::log2(0.7152), 1e-4);
}

TEST(Metering, CountsCoveredPixelsWithLight) {
  std::vector<float> values = repeated({{50, 2}, {50, 0}});  // black
  output::AovImage image = grays(values);
  image.values.insert(image.values.end(), 400, 0.0f);  // background
  EXPECT_NEAR(meanLogLuminance(image).value(), 1, 1e-4);
  EXPECT_NEAR(meanLogLuminance(grays({2}, 0.25f)).value(), 1, 1e-4) << "premultiplied";
  EXPECT_FALSE(meanLogLuminance(grays(repeated({{9, 0}}))));
  EXPECT_FALSE(meanLogLuminance(grays({1}, 0)));
}

TEST(Metering, DoesNotDependOnTheOrder) {
  std::mt19937 random(7);
  std::vector<float> values;
  for (int i = 0; i < 5000; ++i) values.push_back(std::exp2(static_cast<float>(random() % 20000) / 1000 - 10));
  const double before = meanLogLuminance(grays(values)).value();
  std::ranges::shuffle(values, random);
  EXPECT_EQ(meanLogLuminance(grays(values)).value(), before);
}

// --- pictures -------------------------------------------------------------------------------------------------------

class MeteredPictures : public RenderTest {
 protected:
  // Two squares side by side that emit these radiances, without any light.
  static scene::Scene glowing(std::initializer_list<float> radiances) {
    scene::SceneBuilder builder("glowing");
    builder.scene.meshes.push_back(squareMesh());
    for (const float radiance : radiances) {
      const size_t index = builder.scene.materials.size();
      scene::Material material = scene::plainMaterial("glow", vec3(0), 0, 1);
      material.data.specular = 0;
      material.data.emissive = vec3(radiance);
      builder.scene.materials.push_back(material);
      glm::mat4 place(1);
      place[3] = glm::vec4(4.0f * static_cast<float>(index), 0, 0, 1);
      builder.addInstance("square", builder.kRoot, 0, index, place);
    }
    return std::move(builder.scene);
  }
  static Settings metered(Settings settings, float compensation = 0) {
    settings.exposure = {compensation, true};
    return settings;
  }
};

// Luminances from starlight to the sun, which no single exposure holds in half floats. 0.1 %: a half float's rounding.
TEST_F(MeteredPictures, MakeAUniformSurfaceGray) {
  for (const float radiance : {1e-9f, 3e-4f, 1.0f, 2000.0f, 1.6e9f}) {
    SCOPED_TRACE(radiance);
    const scene::Scene scene = glowing({radiance});
    const Settings settings = metered(settingsOf(8, 8, {Aov::Color}));
    const output::FrameOutput frame = renderOne(device(), scene, frontCamera(2), settings);
    EXPECT_NEAR(imageOf(frame, Aov::Color).values[4 * (3 * 8 + 3)], 0.18, 0.18 * 1e-3);
    EXPECT_NEAR(frame.exposure * radiance, 0.18, 0.18 * 1e-3);
    EXPECT_NEAR(output::ev100Of(frame.exposure), std::log2(radiance / 0.18 / 1.2), 2e-3);
  }
}

// A sensor would clip the bright radiance, and round the dark one to 0.
TEST_F(MeteredPictures, AreMeteredBeforeTheSensor) {
  for (const float radiance : {1e-4f, 1.0f, 2000.0f}) {
    SCOPED_TRACE(radiance);
    Settings settings = metered(settingsOf(4, 4, {Aov::Color}));
    settings.fullWell = 10'000, settings.bitDepth = 8, settings.blackLevel = 20, settings.readNoise = 5;
    settings.gain = 4, settings.bayer = Bayer::Rggb, settings.vignetting.coefficients = {-0.5, 0, 0};
    settings.whiteBalance.factors = {2, 1, 1.5};
    const scene::Scene scene = glowing({radiance});
    EXPECT_NEAR(renderOne(device(), scene, frontCamera(), settings).exposure * radiance, 0.18, 0.18 * 1e-3);
  }
}

TEST_F(MeteredPictures, AddTheCompensation) {
  const scene::Scene scene = glowing({50});
  const output::FrameOutput frame =
      renderOne(device(), scene, frontCamera(), metered(settingsOf(4, 4, {Aov::Color}), -2));
  EXPECT_NEAR(imageOf(frame, Aov::Color).values[0], 0.045, 0.045 * 1e-3);
}

TEST_F(MeteredPictures, HaveNoFactorWithoutLight) {
  const output::FrameOutput black =
      renderOne(device(), glowing({0}), frontCamera(), metered(settingsOf(4, 4, {Aov::Color}), 1));
  EXPECT_EQ(black.exposure, 2);
  scene::Camera away = frontCamera();
  away.toWorld[3].x = 100;  // nothing is there
  EXPECT_EQ(renderOne(device(), glowing({5}), away, metered(settingsOf(4, 4, {Aov::Color}))).exposure, 1);
}

// Views in one call have exposures of their own, and each is the picture that its exposure has as a number.
void expectOwnExposures(vk::Device& device, const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                        Settings settings) {
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device, scene, &environment);
  settings.exposure = {0.5f, true};
  const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
  ASSERT_EQ(together.size(), cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    SCOPED_TRACE(i);
    const output::FrameOutput alone = std::move(renderer.render({&cameras[i], 1}, settings).front());
    EXPECT_EQ(together[i].exposure, alone.exposure);
    EXPECT_EQ(together[i].display, alone.display);
    EXPECT_EQ(imageOf(together[i], Aov::Color).values, imageOf(alone, Aov::Color).values);
    Settings number = settings;
    number.exposure = std::log2(alone.exposure);
    if (exposureFactor(number) != alone.exposure) continue;  // no float has exactly this power
    EXPECT_EQ(renderer.render({&cameras[i], 1}, number).front().display, alone.display);
  }
  EXPECT_NE(together[0].exposure, together[1].exposure);
}

std::vector<scene::Camera> camerasOfHall() {
  const scene::Scene& scene = hall();
  scene::Camera other = cameraOf(scene, 40, 24);
  const scene::Camera first = other;
  other.toWorld = other.toWorld * glm::dmat4(glm::dvec4(-1, 0, 0, 0), glm::dvec4(0, -1, 0, 0), glm::dvec4(0, 0, 1, 0),
                                             glm::dvec4(0, 0, 0, 1));  // the other way
  return {first, other};
}

TEST_F(MeteredPictures, AreThoseOfTheirExposures) {
  Settings plain = settingsOf(40, 24, {Aov::Color});
  plain.display = true;
  Settings effects = plain;
  effects.bloom = 0.1f, effects.fogDensity = 0.02f, effects.aa.superSampling = 2;
  effects.background = {.kind = Background::Environment};
  effects.shadows = ShadowFormat::D32;
  Settings forward = plain;
  forward.lighting = &findTechnique("forward");
  Settings rays = plain;
  rays.shadows = ShadowFormat::Rays, rays.indirect = Indirect::OneBounce, rays.samples = 1;
  rays.indirectFilter = IndirectFilter::Spatial;
  Settings multisampled = plain;
  multisampled.aa.samples = 4, multisampled.lighting = &findTechnique("clustered");
  plain.raster = forward.raster = Raster::Hardware;
  effects.raster = rays.raster = multisampled.raster = Raster::Compute;
  std::vector<Settings> all{effects, rays};
  if (latelight::test::runsInFull()) all.insert(all.end(), {plain, forward, multisampled});
  for (const Settings& settings : all) {
    SCOPED_TRACE(fmt::format("{} {} {}", settings.lighting->name, nameOf(settings.shadows), nameOf(settings.raster)));
    expectOwnExposures(device(), hall(), camerasOfHall(), settings);
  }
}

// The second camera needs more rounds than the first one. During its exposure it shows other light than at the
// picture's time, so its exposure is wrong if a later round exposes it at the time of the first camera, or moves it as
// that one.
void expectMeteredDuring(vk::Device& device, const scene::Scene& scene, std::vector<double> SceneState::*durations) {
  const auto at = [](double x) {
    scene::Camera camera = frontCamera();
    camera.toWorld[3].x = x;
    return camera;
  };
  SceneState moment;
  moment.*durations = {0, 0.5};
  moment.motion.cameraAt = [at](size_t camera, double seconds) { return at(camera == 0 ? 0 : seconds == 0 ? 4 : 8); };
  Settings settings = settingsOf(4, 4, {Aov::Color});
  settings.cameraSamples = 2;
  settings.exposure = {0, true};
  Renderer renderer(device, scene, nullptr);
  const std::vector<output::FrameOutput> frames = renderer.render(std::vector{at(0), at(4)}, settings, moment);
  EXPECT_NEAR(frames[0].exposure * 1, 0.18, 0.18 * 1e-3);
  EXPECT_NEAR(frames[1].exposure * 1e9, 0.18, 0.18 * 1e-3);
}

TEST_F(MeteredPictures, KeepTheShuttersOfTheirCameras) {
  expectMeteredDuring(device(), glowing({1, 2000, 1e9f}), &SceneState::shutters);
}

TEST_F(MeteredPictures, KeepTheReadoutsOfTheirCameras) {
  expectMeteredDuring(device(), glowing({1, 2000, 1e9f}), &SceneState::readouts);
}

TEST_F(MeteredPictures, DoNotDependOnStrips) {
  Settings settings = metered(settingsOf(64, 48, {Aov::Color}));
  const scene::Camera camera = cameraOf(hall(), 64, 48);
  const output::FrameOutput whole = renderOne(device(), hall(), camera, settings);
  settings.stripPixels = 64 * 16;
  const output::FrameOutput strips = renderOne(device(), hall(), camera, settings);
  EXPECT_EQ(strips.exposure, whole.exposure);
  EXPECT_EQ(imageOf(strips, Aov::Color).values, imageOf(whole, Aov::Color).values);
}

TEST_F(MeteredPictures, AreMeteredWithoutHistory) {
  Settings settings = settingsOf(8, 8);
  settings.indirect = Indirect::OneBounce, settings.indirectFilter = IndirectFilter::Temporal;
  settings.aa.temporal = true;
  EXPECT_FALSE(keepsHistory(meteringSettings(settings, false)));
}

// A large picture is metered at a fraction of its size.
TEST_F(MeteredPictures, AreMeteredSmall) {
  Settings settings = settingsOf(1500, 800, {Aov::Color, Aov::Depth});
  settings.aa.superSampling = 4, settings.bloom = 1, settings.display = true;
  const Settings metering = meteringSettings(settings, false);
  EXPECT_EQ(metering.width, 500u);
  EXPECT_EQ(metering.height, 266u);
  EXPECT_FALSE(metering.display);
  EXPECT_EQ(metering.aovs, std::vector{Aov::Color});
  EXPECT_EQ(metering.aa, AntiAliasing{});
  EXPECT_EQ(meteringSettings(settings, true).width, 1500u) << "lenses are not scaled";
}

}  // namespace
}  // namespace latelight::render::test
