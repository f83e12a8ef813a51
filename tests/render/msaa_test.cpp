// Multisampling: coverage in closed form, the surfaces of pixels against per-sample shading, and edges against many
// samples per pixel, with both rasters and every supported number of samples.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "models/models.h"
#include "render/lighting/technique.h"
#include "render/options/options.h"
#include "render/support.h"
#include "scene/load/load.h"
#include "shared/light.h"
#include "shared/samples.h"

namespace latelight::render::test {
namespace {

using output::Aov;
using Values = std::vector<float>;

struct Sampling {
  Raster raster;
  uint32_t samples;
};
std::string nameOf(const Sampling& s) {
  return fmt::format("{}{}", s.raster == Raster::Compute ? "compute" : "hardware", s.samples);
}

Settings multisampled(const Sampling& sampling, uint32_t width, uint32_t height, std::vector<Aov> aovs = {Aov::Color}) {
  Settings settings = settingsOf(width, height, std::move(aovs));
  settings.raster = sampling.raster;
  settings.aa.samples = sampling.samples;
  return settings;
}

Values colorOf(Renderer& renderer, const scene::Camera& camera, const Settings& settings) {
  return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
}

// The number of a pixel's samples whose column or row lies before `edge`, in pixels.
uint32_t samplesBefore(uint32_t samples, double edge, bool across) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const shared::vec2 place = shared::samplePlace(samples, i);
    count += (across ? place.x : place.y) < edge;
  }
  return count;
}

class MsaaTest : public RenderTest, public testing::WithParamInterface<Sampling> {
 protected:
  static Settings multisampled(uint32_t width, uint32_t height, std::vector<Aov> aovs = {Aov::Color}) {
    return test::multisampled(GetParam(), width, height, std::move(aovs));
  }
  // The techniques that support these samples. Techniques that draw their lights are not supported with the raster
  // compute.
  static std::vector<const TechniqueInfo*> supportedTechniques() {
    std::vector<const TechniqueInfo*> own;
    for (const TechniqueInfo& technique : techniques())
      if (GetParam().raster == Raster::Hardware || !technique.draws) own.push_back(&technique);
    return own;
  }
  // The fraction of a pixel's samples beyond an edge.
  static float fractionBeyond(double edge, bool across) {
    return 1 -
           static_cast<float>(samplesBefore(GetParam().samples, edge, across)) / static_cast<float>(GetParam().samples);
  }
};

INSTANTIATE_TEST_SUITE_P(All, MsaaTest,
                         testing::Values(Sampling{Raster::Hardware, 4}, Sampling{Raster::Compute, 2},
                                         Sampling{Raster::Compute, 4}, Sampling{Raster::Compute, 8},
                                         Sampling{Raster::Compute, 16}),
                         [](const auto& info) { return nameOf(info.param); });

// A white unlit square, displaced by a fraction of a pixel in an image of kSize pixels that covers 2 by 2 units.
constexpr uint32_t kSize = 32;
scene::Scene movedSquare(glm::vec2 pixels) {
  scene::SceneBuilder builder("square");
  builder.scene.meshes.push_back(squareMesh());
  builder.scene.materials.push_back(scene::plainMaterial("white", glm::vec3(1), 0, 1));
  builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
  const glm::vec3 move = glm::vec3(pixels.x, -pixels.y, 0) * (2.0f / kSize);
  builder.addInstance("square", builder.kRoot, 0, 0,
                      glm::scale(glm::translate(glm::mat4(1), move), glm::vec3(0.5f, 0.5f, 1)));
  return std::move(builder.scene);
}

// The square's left edge lies at 8.4 pixels and its upper edge at 8.7; its right and lower edges have the same
// fractions.
TEST_P(MsaaTest, CoverageIsThatOfTheSamples) {
  const scene::Scene scene = movedSquare({0.4f, 0.7f});
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled(kSize, kSize);
  for (const TechniqueInfo* technique : supportedTechniques()) {
    SCOPED_TRACE(technique->name);
    settings.lighting = technique;
    const Values picture = colorOf(renderer, frontCamera(), settings);
    const auto at = [&](size_t x, size_t y) { return &picture[4 * (y * kSize + x)]; };
    EXPECT_EQ(at(16, 16)[3], 1);
    EXPECT_EQ(at(7, 16)[3], 0);
    EXPECT_EQ(at(8, 16)[3], fractionBeyond(0.4, true));
    EXPECT_EQ(at(24, 16)[3], 1 - fractionBeyond(0.4, true));
    EXPECT_EQ(at(16, 8)[3], fractionBeyond(0.7, false));
    EXPECT_EQ(at(16, 24)[3], 1 - fractionBeyond(0.7, false));
    for (size_t i = 0; i < picture.size(); i += 4)
      for (size_t c = 0; c < 3; ++c)  // premultiplied white, in half floats
        ASSERT_NEAR(picture[i + c], picture[i + 3], 1e-3f * picture[i + 3]) << i / 4;
  }
}

// In partly covered pixels, the background contributes by the uncovered fraction.
TEST_P(MsaaTest, EnvironmentFillsTheUncoveredFraction) {
  scene::Scene scene = movedSquare({0.4f, 0});
  scene.materials.back().data.baseColor = {0.25f, 0.5f, 0, 1};
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  Settings settings = multisampled(kSize, kSize);
  settings.background.kind = Background::Environment;
  const Values picture = colorOf(renderer, frontCamera(), settings);
  const float* edge = &picture[4 * (16 * kSize + 8)];
  const float share = fractionBeyond(0.4, true);
  EXPECT_NEAR(edge[0], share * 0.25f + 1 - share, 1e-3f);
  EXPECT_NEAR(edge[1], share * 0.5f + 1 - share, 1e-3f);
  EXPECT_NEAR(edge[2], 1 - share, 1e-3f);
  for (size_t i = 3; i < picture.size(); i += 4) ASSERT_EQ(picture[i], 1);
}

// The transmittance of fog that thins out with height, from a height over a distance along a direction that climbs by
// `slope` per meter (Wenzel 2006, Real-time Atmospheric Effects in Games). Uniform if the settings' height is 0.
double fogTransmittance(const Settings& s, double from, double slope, double distance) {
  if (s.fogHeight <= 0) return std::exp(-s.fogDensity * distance);
  const double start = s.fogDensity * std::exp(-from / s.fogHeight), rate = slope / s.fogHeight;
  return std::exp(-start * (rate > 0 ? (1 - std::exp(-rate * distance)) / rate : distance));
}

// The square of movedSquare(), whose left edge lies at 8.4 pixels, before a wall, the environment or nothing.
enum class Behind : uint8_t { Wall, Environment, Nothing };
scene::Scene squareBefore(Behind behind, bool coat) {
  scene::Scene scene = movedSquare({0.4f, 0});
  scene.materials[0].data.baseColor = {0, 0, 0, 1};
  if (coat) {  // no light but its emission, which the coat attenuates
    scene.materials[0] = scene::plainMaterial("coated", glm::vec3(0), 0, 1);
    scene.materials[0].data.emissive = {0.1f, 0.9f, 0.4f};
    scene.materials[0].data.layers.clearcoat = 1;
  }
  if (behind != Behind::Wall) return scene;
  scene.materials.push_back(scene::plainMaterial("wall", {0.9f, 0.8f, 0.2f}, 0, 1));
  scene.materials.back().data.flags |= shared::kMaterialUnlit;
  scene::Instance wall = scene.instances[0];
  wall.material = 1, wall.id = 99;
  for (int axis = 0; axis < 3; ++axis) wall.toWorld[axis] *= 16;
  wall.toWorld[3].y += 3;
  scene.instances.push_back(wall);
  return scene;
}

// Orthographic, looks at the origin from 4 m away along +Y, turned up by an angle in radians.
scene::Camera cameraTurnedUp(double pitch) {
  scene::Camera camera = frontCamera();
  const glm::dvec3 forward(0, std::cos(pitch), std::sin(pitch)), up(0, -std::sin(pitch), std::cos(pitch));
  camera.toWorld[1] = glm::dvec4(forward, 0), camera.toWorld[2] = glm::dvec4(up, 0);
  camera.toWorld[3] = glm::dvec4(-4.0 * forward, 1);
  camera.farClip = 100;
  return camera;
}

// Compares pixels of one row inside the square, outside it and on its edge with `share` of the square. The square and
// what is behind it have their own fog.
void expectFog(const Values& plain, const Values& picture, const scene::Camera& camera, const Settings& settings,
               Behind behind, double share) {
  constexpr size_t kRow = 16, kOut = 4 * kRow * kSize, kEdge = kOut + 4 * 8, kInside = kOut + 4 * 16;
  const glm::dvec3 forward(camera.toWorld[1]), up(camera.toWorld[2]);
  const glm::dvec3 start = glm::dvec3(camera.toWorld[3]) + up * (1 - 2 * (kRow + 0.5) / kSize);
  const auto through = [&](double y) {
    return fogTransmittance(settings, start.z, forward.z, (y - start.y) / forward.y);
  };
  const double near = through(0), far = through(behind == Behind::Wall ? 3 : 1e9);
  for (int c = 0; c < 4; ++c) {
    const double added = c < 3 ? double{settings.fogColor[c]} : 1.0;
    const double square = double{plain[kInside + c]} * near + added * (1 - near);
    const double rest = double{plain[kOut + c]} * far + added * (1 - far);
    EXPECT_NEAR(picture[kInside + c], square, 2e-3) << c;
    EXPECT_NEAR(picture[kOut + c], rest, 2e-3) << c;
    EXPECT_NEAR(picture[kEdge + c], share * square + (1 - share) * rest, 3e-3) << c;
  }
}

TEST_P(MsaaTest, FogAppliesToEachSurface) {
  const scene::Environment white = constantEnvironment();
  for (const bool coat : {false, true})
    for (const Behind behind : {Behind::Wall, Behind::Environment, Behind::Nothing}) {
      const scene::Scene scene = squareBefore(behind, coat);
      const bool isSky = behind == Behind::Environment;
      Renderer renderer(device(), scene, isSky ? &white : nullptr);
      Settings settings = multisampled(kSize, kSize);
      if (isSky) settings.background.kind = Background::Environment;
      settings.fogColor = {0.75f, 0.25f, 0.5f};
      for (const double pitch : {0.0, 0.5})
        for (const float height : {0.0f, 2.0f})
          for (const TechniqueInfo* technique : supportedTechniques()) {
            SCOPED_TRACE(fmt::format("{} coat {} behind {} pitch {} height {}", technique->name, coat, int(behind),
                                     pitch, height));
            const scene::Camera camera = cameraTurnedUp(pitch);
            settings.lighting = technique, settings.fogHeight = height, settings.fogDensity = 0;
            const Values plain = colorOf(renderer, camera, settings);
            settings.fogDensity = 0.1f;
            const Values picture = colorOf(renderer, camera, settings);
            expectFog(plain, picture, camera, settings, behind, double{fractionBeyond(0.4, true)});
          }
    }
}

// Alpha masks are tested per sample, so the edge of a mask within a pixel covers part of the pixel.
TEST_P(MsaaTest, MasksAreTestedPerSample) {
  scene::Scene scene = movedSquare({0, 0});
  scene.textures.push_back(textureOf(2, 1, true, {{255, 255, 255, 255}, {255, 255, 255, 0}}));
  setTexture(scene.materials.back(), shared::kTextureBaseColor, 0);  // alpha falls smoothly from 1 to 0
  scene.materials.back().data.flags |= shared::kMaterialMasked;
  for (const float cutoff : {0.46f, 0.43f}) {  // edges that pass between samples
    scene.materials.back().data.alphaCutoff = cutoff;
    Renderer renderer(device(), scene, nullptr);
    const double edge = 8 + 16 * (0.25 + 0.5 * (1 - cutoff));  // pixels from the left
    for (const char* technique : {"forward", "fullscreen"}) {
      Settings settings = multisampled(kSize, kSize);
      settings.lighting = &findTechnique(technique);
      if (settings.lighting->draws && settings.raster == Raster::Compute) continue;
      const Values picture = colorOf(renderer, frontCamera(), settings);
      for (uint32_t x = 12; x < 20; ++x) {
        ASSERT_EQ(picture[4 * (16 * kSize + x) + 3], 1 - fractionBeyond(edge - x, true)) << cutoff << ' ' << x;
      }
    }
  }
}

// A lit square that fills the image: its surfaces are shaded at pixel centers, as without multisampling.
TEST_P(MsaaTest, PixelsOfOneSurfaceAreShadedAtTheirCenter) {
  scene::Scene scene = movedSquare({0, 0});
  scene.materials.back() = scene::plainMaterial("glossy", glm::vec3(0.8f), 0.3f, 0.3f);
  scene::Light& light = scene.lights.emplace_back();
  light.type = shared::kLightPoint;
  light.position = {0.1f, -0.3f, 0.1f};
  light.intensity = 1;
  Renderer renderer(device(), scene, nullptr);
  for (const TechniqueInfo* technique : supportedTechniques()) {
    if (technique->forward) continue;
    SCOPED_TRACE(technique->name);
    Settings settings = multisampled(kSize, kSize);
    settings.lighting = technique;
    const Values several = colorOf(renderer, frontCamera(0.5f), settings);
    settings.aa.samples = 1;
    const Values one = colorOf(renderer, frontCamera(0.5f), settings);
    for (size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(several[i], one[i], 2e-3f * one[i] + 1e-5f) << i / 4;
  }
}

// Several views are array layers of one frame.
TEST_P(MsaaTest, ViewsOfABatchEqualSingleViews) {
  const scene::Scene scene = movedSquare({0.4f, 0.7f});
  Renderer renderer(device(), scene, nullptr);
  const scene::Camera cameras[] = {frontCamera(), frontPerspective(0.6f, 2)};
  for (const TechniqueInfo* technique : supportedTechniques()) {
    SCOPED_TRACE(technique->name);
    Settings settings = multisampled(kSize, kSize, {Aov::Color, Aov::Samples});
    settings.lighting = technique;
    const std::vector<output::FrameOutput> both = renderer.render(cameras, settings);
    for (size_t i = 0; i < 2; ++i) {
      const output::FrameOutput alone = std::move(renderer.render({&cameras[i], 1}, settings).front());
      for (Aov aov : settings.aovs) EXPECT_EQ(imageOf(both[i], aov).values, imageOf(alone, aov).values) << i;
    }
  }
}

// Layouts that store positions have that of a surface's first sample, but surfaces are lit at the mean of their
// samples, as in layouts that compute positions from depth. Light lists hold the lights there.
TEST_P(MsaaTest, LayoutsThatStorePositionsAreLitAtTheMeanOfSamples) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=250");
  Renderer renderer(device(), scene, nullptr);
  const scene::Camera camera = cameraOf(scene, 96, 54);
  const auto colorsOf = [&](const char* layout, const char* technique) {
    Settings settings = multisampled(96, 54);
    settings.layout = &findLayout(layout);
    settings.lighting = &findTechnique(technique);
    return colorOf(renderer, camera, settings);
  };
  const Values expected = colorsOf("compact", "fullscreen");
  for (const char* layout : {"exact", "plain", "blog"}) {
    const Values all = colorsOf(layout, "fullscreen"), listed = colorsOf(layout, "clustered");
    size_t others = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      ASSERT_NEAR(listed[i], all[i], 2e-3f * all[i] + 1e-4f) << layout << ", pixel " << i / 4;
      others += std::abs(all[i] - expected[i]) > 0.02f * expected[i] + 2e-3f;
    }
    EXPECT_LT(others, all.size() / 200) << layout;
  }
}

// Frames with one and with four samples in one graph: their images alias the same memory, under synchronization
// validation.
using MsaaGraph = RenderTest;
TEST_F(MsaaGraph, CountsAndDataShareMemory) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Settings settings = settingsOf(7, 40, {Aov::Emissive, Aov::LightsUsed, Aov::Samples});
  settings.raster = Raster::Hardware;
  settings.aa.samples = 4;
  settings.layout = &findLayout("engine");
  const output::FrameOutput frame = renderOne(device(), scene, cameraOf(scene, 7, 40), settings);
  EXPECT_EQ(imageOf(frame, Aov::Samples).values.size(), size_t{7} * 40);
}

// More lights than the stencil can distinguish, because one of its bits classifies the pixels.
using MsaaVolumes = RenderTest;
TEST_F(MsaaVolumes, ManyLightsAgree) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=250");
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled({Raster::Hardware, 4}, 64, 36, {});
  settings.display = true;
  const scene::Camera camera = cameraOf(scene, 64, 36);
  const std::vector<uint8_t> expected = std::move(renderer.render({&camera, 1}, settings).front().display);
  settings.lighting = &findTechnique("volumes");
  for (const char* order : {"classic", "killzone"}) {
    settings.volumesOrder = choiceNamed<VolumesOrder>(order).value();
    const std::vector<uint8_t> volumes = std::move(renderer.render({&camera, 1}, settings).front().display);
    int worst = 0;
    for (size_t i = 0; i < expected.size(); ++i) worst = std::max(worst, std::abs(expected[i] - volumes[i]));
    EXPECT_LE(worst, 1) << order;
  }
}

// Each error is one sentence: unsupported numbers of samples, numbers that the graphics pipeline lacks, and two
// sampling methods at once.
TEST(MsaaSettings, UnsupportedCombinationsAreRejected) {
  const auto errorOf = [](Raster raster, uint32_t samples, const char* technique, uint32_t superSampling = 1) {
    Settings settings = multisampled({raster, samples}, 8, 8);
    settings.lighting = &findTechnique(technique);
    settings.aa.superSampling = superSampling;
    try {
      checkSettings(settings);
      return std::string();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      return std::string(error.what());
    }
  };
  for (const uint32_t samples : {1u, 2u, 4u, 8u, 16u}) EXPECT_EQ(errorOf(Raster::Compute, samples, "tiled"), "");
  EXPECT_EQ(errorOf(Raster::Hardware, 4, "forward"), "");
  EXPECT_EQ(errorOf(Raster::Auto, 8, "clustered"), "");
  for (const uint32_t samples : {0u, 3u, 12u, 32u})
    EXPECT_NE(errorOf(Raster::Compute, samples, "tiled").find("1, 2, 4, 8 or 16"), std::string::npos) << samples;
  EXPECT_NE(errorOf(Raster::Hardware, 8, "tiled").find("requires the raster compute"), std::string::npos);
  EXPECT_NE(errorOf(Raster::Compute, 16, "forward").find("unlike forward"), std::string::npos);
  EXPECT_NE(errorOf(Raster::Auto, 2, "volumes").find("unlike volumes"), std::string::npos);
  EXPECT_NE(errorOf(Raster::Compute, 4, "tiled", 2).find("use one"), std::string::npos);
}

// --- surfaces per pixel ---------------------------------------------------------------------------------------------

// Unlit vertical strips, each `width` pixels wide, starting at the image's left edge.
scene::Scene strips(const std::vector<glm::vec3>& colors, double width) {
  scene::SceneBuilder builder("strips");
  builder.scene.meshes.push_back(squareMesh());
  for (size_t i = 0; i < colors.size(); ++i) {
    builder.scene.materials.push_back(scene::plainMaterial("m", colors[i], 0, 1));
    builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
    const double half = width / kSize, center = -1 + (2.0 * static_cast<double>(i) + 1) * half;
    builder.addInstance("strip", builder.kRoot, 0, static_cast<uint32_t>(i),
                        glm::scale(glm::translate(glm::mat4(1), glm::vec3(center, 0, 0)), glm::vec3(half, 1, 1)));
  }
  return std::move(builder.scene);
}

// A pixel with as many surfaces as samples: no surface is dropped, and each has the same weight.
TEST_P(MsaaTest, EverySampleMayHaveItsOwnSurface) {
  const uint32_t samples = GetParam().samples;
  std::vector<glm::vec3> colors;
  glm::vec3 sum(0);
  for (uint32_t i = 0; i < samples; ++i) {
    colors.emplace_back(i & 1u ? 0.9f : 0.1f, i & 2u ? 0.8f : 0.2f, static_cast<float>(i) / 16);
    sum += colors.back();
  }
  const scene::Scene scene = strips(colors, 1.0 / samples);
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled(kSize, kSize, {Aov::Color, Aov::Samples});
  settings.countSurfaces = true;
  for (const TechniqueInfo* technique : supportedTechniques()) {
    if (technique->forward) continue;
    SCOPED_TRACE(technique->name);
    settings.lighting = technique;
    const scene::Camera camera = frontCamera();
    const RenderResult result = renderer.submit({&camera, 1}, settings).take();
    const output::FrameOutput& frame = result.frames.front();
    for (uint32_t y = 0; y < kSize; ++y) {
      const size_t pixel = size_t{y} * kSize;
      ASSERT_EQ(imageOf(frame, Aov::Samples).values[pixel], samples) << y;
      ASSERT_EQ(imageOf(frame, Aov::Samples).values[pixel + 1], 0) << y;
      const float* found = &imageOf(frame, Aov::Color).values[4 * pixel];
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(found[c], sum[c] / static_cast<float>(samples), 2e-3f) << y;
      ASSERT_EQ(found[3], 1) << y;
    }
    const ShadingCounts counts = result.statistics.shadingCounts.value();
    EXPECT_EQ(counts.pixels, kSize * kSize);
    EXPECT_EQ(counts.drawn, kSize);
    EXPECT_EQ(counts.several, kSize);
    EXPECT_EQ(counts.shadings, kSize * samples);
  }
}

// Two colors meet within a pixel: the pixel has two surfaces, each weighted by its coverage; with equal colors it has
// one.
TEST_P(MsaaTest, ColorsMeetByTheirCoverage) {
  const glm::vec3 left(0.9f, 0.1f, 0.2f), right(0.1f, 0.3f, 0.8f);
  for (const bool alike : {false, true}) {
    const scene::Scene scene = strips({left, alike ? left : right}, 10.3);
    Renderer renderer(device(), scene, nullptr);
    const Settings settings = multisampled(kSize, kSize, {Aov::Color, Aov::Samples});
    const scene::Camera camera = frontCamera();
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
    const uint32_t before = samplesBefore(GetParam().samples, 0.3, true);
    const float share = static_cast<float>(before) / static_cast<float>(GetParam().samples);
    const bool both = !alike && before > 0;
    for (const size_t pixel : {size_t{5} * kSize + 10, size_t{20} * kSize + 10}) {
      EXPECT_EQ(imageOf(frame, Aov::Samples).values[pixel], both ? 2 : 1);
      const glm::vec3 expected = alike ? left : left * share + right * (1 - share);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(imageOf(frame, Aov::Color).values[4 * pixel + c], expected[c], 1e-3f);
    }
  }
}

// --- shading per surface against shading per sample -----------------------------------------------------------------

// If shading is constant over each surface, shading per sample and per surface are equal.
scene::Scene flatSpheres() {
  scene::SceneBuilder builder("spheres");
  builder.scene.meshes = {sphereMesh(0.4f), squareMesh()};
  const auto add = [&](glm::vec3 color, uint32_t mesh, glm::mat4 place) {
    builder.scene.materials.push_back(scene::plainMaterial("m", color, 0, 1));
    builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
    builder.addInstance("thing", builder.kRoot, mesh, static_cast<uint32_t>(builder.scene.materials.size()) - 1, place);
  };
  add({0.9f, 0.3f, 0.1f}, 0, glm::translate(glm::mat4(1), glm::vec3(-0.2f, 0.1f, 0)));
  add({0.1f, 0.8f, 0.3f}, 0, glm::translate(glm::mat4(1), glm::vec3(0.25f, -0.1f, 0.1f)));  // intersects the first
  add({0.2f, 0.3f, 0.9f}, 1, glm::rotate(glm::mat4(1), 0.5f, glm::vec3(0.6f, 0.64f, 0.48f)));
  return std::move(builder.scene);
}

TEST_P(MsaaTest, SurfacesOfConstantShadingLoseNothing) {
  const scene::Scene scene = flatSpheres();
  Renderer renderer(device(), scene, nullptr);
  for (const TechniqueInfo* technique : supportedTechniques()) {
    if (technique->forward) continue;
    SCOPED_TRACE(technique->name);
    Settings settings = multisampled(64, 64, {Aov::Color, Aov::Samples});
    settings.lighting = technique;
    const scene::Camera camera = frontCamera();
    const output::FrameOutput surfaces = std::move(renderer.render({&camera, 1}, settings).front());
    settings.everySample = true;
    const output::FrameOutput samples = std::move(renderer.render({&camera, 1}, settings).front());
    size_t several = 0;
    for (size_t i = 0; i < 64 * 64; ++i) {
      for (size_t c = 4 * i; c < 4 * i + 4; ++c)
        ASSERT_NEAR(imageOf(surfaces, Aov::Color).values[c], imageOf(samples, Aov::Color).values[c], 1e-3f) << i;
      several += imageOf(surfaces, Aov::Samples).values[i] > 1;
      const float coverage = imageOf(samples, Aov::Color).values[4 * i + 3];
      ASSERT_EQ(imageOf(samples, Aov::Samples).values[i], static_cast<float>(GetParam().samples) * coverage) << i;
    }
    EXPECT_GT(several, 50u);
    EXPECT_LT(several, 64 * 64 / 4u);
  }
}

// A white unlit surface has the value of its coverage, also where attributes are evaluated at the center of a part of
// the samples.
TEST_P(MsaaTest, WhiteSurfacesHaveTheirCoverage) {
  scene::SceneBuilder builder("sphere");
  builder.scene.meshes = {sphereMesh(0.4f)};
  builder.scene.materials.push_back(scene::plainMaterial("m", {1, 1, 1}, 0, 1));
  builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
  builder.addInstance("sphere", builder.kRoot, 0, 0, glm::translate(glm::mat4(1), glm::vec3(0.05f, 0, 0.3f)));
  Renderer renderer(device(), builder.scene, nullptr);
  for (const TechniqueInfo* technique : supportedTechniques()) {
    SCOPED_TRACE(technique->name);
    Settings settings = multisampled(24, 24);
    settings.lighting = technique;
    const Values color = colorOf(renderer, frontCamera(), settings);
    size_t edges = 0;
    for (size_t i = 0; i < 24 * 24; ++i) {
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(color[4 * i + c], color[4 * i + 3], 1e-3f) << i;
      edges += color[4 * i + 3] > 0 && color[4 * i + 3] < 1;
    }
    EXPECT_GT(edges, 10u);
  }
}

// The difference of displayed values, which are clamped.
double difference(const Values& a, const Values& b, size_t pixel) {
  double sum = 0;
  for (size_t c = 4 * pixel; c < 4 * pixel + 4; ++c)
    sum += std::abs(double(std::clamp(a[c], 0.0f, 1.0f)) - double(std::clamp(b[c], 0.0f, 1.0f)));
  return sum / 4;
}

// More samples approach the result of 256 samples. Shading is constant, so coverage is the only error.
using MsaaSamples = RenderTest;
TEST_F(MsaaSamples, TheErrorDecreasesWithTheirNumber) {
  constexpr uint32_t kWidth = 32;
  const scene::Scene scene = flatSpheres();
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled({Raster::Compute, 1}, kWidth, kWidth);
  settings.aa.superSampling = 16;
  const Values many = colorOf(renderer, frontCamera(), settings);
  settings.aa.superSampling = 1;
  double before = 1e9;
  for (const uint32_t samples : {1u, 2u, 4u, 8u, 16u}) {
    settings.aa.samples = samples;
    const Values some = colorOf(renderer, frontCamera(), settings);
    double error = 0;
    for (size_t i = 0; i < kWidth * kWidth; ++i) error += std::pow(difference(some, many, i), 2);
    fmt::print("{} samples: {:.4f} of squared error\n", samples, error);
    EXPECT_LT(error, before * 0.6) << samples;
    before = error;
  }
}

struct ModelCase {
  const char* name;
  Sampling sampling;
  double maxShare;        // fraction of the drawn pixels that are shaded per sample
  double maxDifference;   // mean difference over the image from shading every sample
  double minImprovement;  // squared error at edges without multisampling, relative to that with it
  double maxLoss = 1;     // in dB at edges, compared with shading every sample
};

std::string nameOf(const ModelCase& c) {
  const std::string name = c.name;
  return name.substr(0, name.find('.')) + "_" + nameOf(c.sampling);
}

struct Model {
  scene::Scene scene;
  std::optional<scene::Environment> environment;
};
Model load(const std::string& name) {
  Model model{name == "hall"      ? scene::load("builtin:hall,triangles=60k,lights=20")
              : name == "spheres" ? scene::load("builtin:spheres")
                                  : scene::load(models::modelPath(name).string()),
              {}};
  if (model.scene.lights.empty()) model.environment = constantEnvironment();
  return model;
}

class MsaaModels : public RenderTest, public testing::WithParamInterface<ModelCase> {};

// Pixels with a neighbor that shows another object are edges, regardless of how multisampling classifies them.
std::vector<bool> edges(const output::AovImage& ids) {
  std::vector<bool> edge(ids.ids.size());
  for (uint32_t y = 0; y < ids.height; ++y)
    for (uint32_t x = 0; x < ids.width; ++x)
      for (uint32_t v = std::max(y, 1u) - 1; v <= std::min(y + 1, ids.height - 1); ++v)
        for (uint32_t u = std::max(x, 1u) - 1; u <= std::min(x + 1, ids.width - 1); ++u)
          if (ids.ids[v * ids.width + u] != ids.ids[y * ids.width + x]) edge[y * ids.width + x] = true;
  return edge;
}

TEST_P(MsaaModels, EdgesAreBetterByAFactor) {
  constexpr uint32_t kWidth = 192, kHeight = 108;
  const std::string name = GetParam().name;
  const Model model = load(name);
  Renderer renderer(device(), model.scene, model.environment ? &*model.environment : nullptr);
  const scene::Camera camera = cameraOf(model.scene, kWidth, kHeight);
  Settings settings = multisampled(GetParam().sampling, kWidth, kHeight);
  settings.countSurfaces = true;
  const RenderResult result = renderer.submit({&camera, 1}, settings).take();
  const Values surfaces = imageOf(result.frames.front(), Aov::Color).values;
  const ShadingCounts counts = result.statistics.shadingCounts.value();
  settings.everySample = true;
  const Values samples = colorOf(renderer, camera, settings);
  settings = settingsOf(kWidth, kHeight, {Aov::Color, Aov::Part});
  const output::FrameOutput plain = std::move(renderer.render({&camera, 1}, settings).front());
  const Values& none = imageOf(plain, Aov::Color).values;
  settings.aovs = {Aov::Color};
  settings.aa.superSampling = 4;
  const Values sixteen = colorOf(renderer, camera, settings);

  const std::vector<bool> edge = edges(imageOf(plain, Aov::Part));
  double off = 0, errorNone = 0, errorSome = 0, errorEvery = 0;
  size_t count = 0;
  for (size_t i = 0; i < edge.size(); ++i) {
    off += difference(surfaces, samples, i);
    if (!edge[i]) continue;
    ++count;
    errorNone += std::pow(difference(none, sixteen, i), 2);
    errorSome += std::pow(difference(surfaces, sixteen, i), 2);
    errorEvery += std::pow(difference(samples, sixteen, i), 2);
  }
  off /= static_cast<double>(edge.size());
  const double share = static_cast<double>(counts.several) / static_cast<double>(counts.drawn);
  const auto psnr = [&](double error) { return -10 * std::log10(error / static_cast<double>(count)); };
  fmt::print(
      "{}: {:.1f} % of the drawn pixels shaded per sample, {:.3f} shadings a pixel; from every sample {:.5f} off\n",
      nameOf(GetParam()), 100 * share, static_cast<double>(counts.shadings) / static_cast<double>(counts.drawn), off);
  fmt::print("  {} edge pixels against ss4: none {:.2f} dB, so {:.2f} dB, every sample {:.2f} dB; better by {:.2f}\n",
             count, psnr(errorNone), psnr(errorSome), psnr(errorEvery), errorNone / errorSome);
  EXPECT_GT(count, 200u);
  EXPECT_LT(share, GetParam().maxShare);
  EXPECT_LT(off, GetParam().maxDifference);
  EXPECT_GT(errorNone / errorSome, GetParam().minImprovement);
  EXPECT_LT(psnr(errorEvery) - psnr(errorSome), GetParam().maxLoss);
}

std::vector<ModelCase> modelCases() {
  // With the raster compute, every sample has its own texels, so shading once per surface loses more.
  constexpr Sampling kHardware{Raster::Hardware, 4}, kFour{Raster::Compute, 4}, kSixteen{Raster::Compute, 16};
  std::vector<ModelCase> cases{{"hall", kHardware, 0.45, 0.004, 3},
                               {"hall", kSixteen, 0.5, 0.005, 3, 2},
                               {"spheres", kHardware, 0.1, 0.004, 5},
                               {"textured.glb", kHardware, 0.1, 0.001, 5},
                               {"textured.glb", kFour, 0.1, 0.004, 5}};
  if (!models::withReal({}, {"DamagedHelmet.glb"}).empty())
    for (const Sampling sampling : {kHardware, kFour}) cases.push_back({"DamagedHelmet.glb", sampling, 0.5, 0.002, 5});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, MsaaModels, testing::ValuesIn(modelCases()),
                         [](const auto& info) { return nameOf(info.param); });

}  // namespace
}  // namespace latelight::render::test
