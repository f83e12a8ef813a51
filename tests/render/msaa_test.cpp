// Multisampling: coverage in closed form, the surfaces of pixels against shading every sample, and edges against 16
// samples a pixel.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "models/models.h"
#include "render/lighting/technique.h"
#include "render/support.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using output::Aov;
using Values = std::vector<float>;

Settings multisampled(uint32_t width, uint32_t height, std::vector<Aov> aovs = {Aov::Color}) {
  Settings settings = settingsOf(width, height, std::move(aovs));
  settings.aa.samples = 4;
  return settings;
}

struct MsaaTest : RenderTest {
  static Values color(Renderer& renderer, const scene::Camera& camera, const Settings& settings) {
    return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
  }
};

// A white unlit square, moved by a part of a pixel of a picture of kSize pixels that shows 2 by 2 units.
constexpr uint32_t kSize = 32;
scene::Scene movedSquare(glm::vec2 pixels) {
  scene::builtin::SceneBuilder builder("square");
  builder.scene.meshes.push_back(squareMesh());
  builder.scene.materials.push_back(scene::builtin::plainMaterial("white", glm::vec3(1), 0, 1));
  builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
  const glm::vec3 move = glm::vec3(pixels.x, -pixels.y, 0) * (2.0f / kSize);
  builder.addInstance("square", builder.kRoot, 0, 0,
                      glm::scale(glm::translate(glm::mat4(1), move), glm::vec3(0.5f, 0.5f, 1)));
  return std::move(builder.scene);
}

// The square's left edge lies at 8.4 pixels: of the samples at 0.125, 0.375, 0.625 and 0.875 two are inside. Its upper
// edge at 8.7: one row of samples is.
TEST_F(MsaaTest, CoverageIsThatOfTheFourSamples) {
  const scene::Scene scene = movedSquare({0.4f, 0.7f});
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled(kSize, kSize);
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    settings.lighting = &technique;
    const Values picture = color(renderer, frontCamera(), settings);
    const auto at = [&](size_t x, size_t y) { return &picture[4 * (y * kSize + x)]; };
    EXPECT_EQ(at(16, 16)[3], 1);
    EXPECT_EQ(at(7, 16)[3], 0);
    EXPECT_EQ(at(8, 16)[3], 0.5f);
    EXPECT_EQ(at(24, 16)[3], 0.5f);
    EXPECT_EQ(at(16, 8)[3], 0.25f);
    EXPECT_EQ(at(16, 24)[3], 0.75f);
    for (size_t i = 0; i < picture.size(); i += 4)
      for (size_t c = 0; c < 3; ++c) ASSERT_EQ(picture[i + c], picture[i + 3]) << i / 4;  // premultiplied white
  }
}

// What is behind a partly covered pixel shows through by as much as is not covered.
TEST_F(MsaaTest, EnvironmentFillsWhatIsNotCovered) {
  scene::Scene scene = movedSquare({0.4f, 0});
  scene.materials.back().data.baseColor = {0.25f, 0.5f, 0, 1};
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  Settings settings = multisampled(kSize, kSize);
  settings.background.kind = Background::Environment;
  const Values picture = color(renderer, frontCamera(), settings);
  const float* edge = &picture[4 * (16 * kSize + 8)];
  EXPECT_NEAR(edge[0], 0.5f * 0.25f + 0.5f, 1e-3f);
  EXPECT_NEAR(edge[1], 0.5f * 0.5f + 0.5f, 1e-3f);
  EXPECT_NEAR(edge[2], 0.5f, 1e-3f);
  for (size_t i = 3; i < picture.size(); i += 4) ASSERT_EQ(picture[i], 1);
}

// Masks are cut for each sample: a mask's edge at a third of a pixel covers part of it.
TEST_F(MsaaTest, MasksAreCutForEachSample) {
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
      const Values picture = color(renderer, frontCamera(), settings);
      for (uint32_t x = 12; x < 20; ++x) {
        int covered = 0;
        for (double sample : {0.125, 0.375, 0.625, 0.875}) covered += x + sample < edge;
        ASSERT_EQ(picture[4 * (16 * kSize + x) + 3], static_cast<float>(covered) / 4) << cutoff << ' ' << x;
      }
    }
  }
}

// A lit square that fills the picture: its surfaces are lit at the pixels' centres, as without samples.
TEST_F(MsaaTest, PixelsOfOneSurfaceAreLitAtTheirCentre) {
  scene::Scene scene = movedSquare({0, 0});
  scene.materials.back() = scene::builtin::plainMaterial("glossy", glm::vec3(0.8f), 0.3f, 0.3f);
  scene::Light& light = scene.lights.emplace_back();
  light.type = shared::kLightPoint;
  light.position = {0.1f, -0.3f, 0.1f};
  light.intensity = 1;
  Renderer renderer(device(), scene, nullptr);
  for (const TechniqueInfo& technique : techniques()) {
    if (technique.forward) continue;
    SCOPED_TRACE(technique.name);
    Settings settings = multisampled(kSize, kSize);
    settings.lighting = &technique;
    const Values four = color(renderer, frontCamera(0.5f), settings);
    settings.aa.samples = 1;
    const Values one = color(renderer, frontCamera(0.5f), settings);
    for (size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(four[i], one[i], 2e-3f * one[i] + 1e-5f) << i / 4;
  }
}

// Several views are layers of one frame.
TEST_F(MsaaTest, ViewsAtOnceAreTheViewsAlone) {
  const scene::Scene scene = movedSquare({0.4f, 0.7f});
  Renderer renderer(device(), scene, nullptr);
  const scene::Camera cameras[] = {frontCamera(), frontPerspective(0.6f, 2)};
  for (const char* technique : {"fullscreen", "volumes"}) {
    SCOPED_TRACE(technique);
    Settings settings = multisampled(kSize, kSize, {Aov::Color, Aov::Samples});
    settings.lighting = &findTechnique(technique);
    const std::vector<output::FrameOutput> both = renderer.render(cameras, settings);
    for (size_t i = 0; i < 2; ++i) {
      const output::FrameOutput alone = std::move(renderer.render({&cameras[i], 1}, settings).front());
      for (Aov aov : settings.aovs) EXPECT_EQ(imageOf(both[i], aov).values, imageOf(alone, aov).values) << i;
    }
  }
}

// More lights than stencil has values beside the bit that splits the pixels.
// Frames with one and with four samples in one graph: images of both follow each other in the same memory, under
// synchronization validation.
TEST_F(MsaaTest, CountsAndDataShareAGraph) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Settings settings = settingsOf(7, 40, {Aov::Emissive, Aov::LightsUsed, Aov::Samples});
  settings.raster = Raster::Hardware;
  settings.aa.samples = 4;
  settings.layout = &findLayout("engine");
  const output::FrameOutput frame = renderOne(device(), scene, cameraOf(scene, 7, 40), settings);
  EXPECT_EQ(imageOf(frame, Aov::Samples).values.size(), size_t{7} * 40);
}

TEST_F(MsaaTest, VolumesOfManyLightsAgree) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=250");
  Renderer renderer(device(), scene, nullptr);
  Settings settings = multisampled(64, 36, {});
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

TEST_F(MsaaTest, OtherNumbersOfSamplesAreRefused) {
  Settings settings = multisampled(8, 8);
  EXPECT_NO_THROW(checkSettings(settings));
  settings.aa.superSampling = 2;
  EXPECT_THROW(checkSettings(settings), Error);
  settings = multisampled(8, 8);
  settings.aa.samples = 8;
  EXPECT_THROW(checkSettings(settings), Error);
}

// --- surfaces against samples ---------------------------------------------------------------------------------------

// Where shading is the same all over a surface it is one and the same to shade each sample or each surface.
TEST_F(MsaaTest, SurfacesOfConstantShadingLoseNothing) {
  scene::builtin::SceneBuilder builder("spheres");
  builder.scene.meshes = {sphereMesh(0.4f), squareMesh()};
  const auto add = [&](glm::vec3 color, uint32_t mesh, glm::mat4 place) {
    builder.scene.materials.push_back(scene::builtin::plainMaterial("m", color, 0, 1));
    builder.scene.materials.back().data.flags |= shared::kMaterialUnlit;
    builder.addInstance("thing", builder.kRoot, mesh, static_cast<uint32_t>(builder.scene.materials.size()) - 1, place);
  };
  add({0.9f, 0.3f, 0.1f}, 0, glm::translate(glm::mat4(1), glm::vec3(-0.2f, 0.1f, 0)));
  add({0.1f, 0.8f, 0.3f}, 0, glm::translate(glm::mat4(1), glm::vec3(0.25f, -0.1f, 0.1f)));  // cuts through the first
  add({0.2f, 0.3f, 0.9f}, 1, glm::rotate(glm::mat4(1), 0.5f, glm::vec3(0.6f, 0.64f, 0.48f)));
  Renderer renderer(device(), builder.scene, nullptr);
  for (const TechniqueInfo& technique : techniques()) {
    if (technique.forward) continue;
    SCOPED_TRACE(technique.name);
    Settings settings = multisampled(64, 64, {Aov::Color, Aov::Samples});
    settings.lighting = &technique;
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
      ASSERT_EQ(imageOf(samples, Aov::Samples).values[i], 4 * coverage) << i;
    }
    EXPECT_GT(several, 50u);
    EXPECT_LT(several, 64 * 64 / 4u);
  }
}

struct ModelCase {
  const char* name;
  double mostShare;    // of the drawn pixels that are shaded per sample
  double mostOff;      // from shading every sample, mean over the picture
  double leastBetter;  // squared error at edges, none over msaa4
};

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

// What is shown: clamped as a display would.
double difference(const Values& a, const Values& b, size_t pixel) {
  double sum = 0;
  for (size_t c = 4 * pixel; c < 4 * pixel + 4; ++c)
    sum += std::abs(double(std::clamp(a[c], 0.0f, 1.0f)) - double(std::clamp(b[c], 0.0f, 1.0f)));
  return sum / 4;
}

class MsaaModels : public MsaaTest, public testing::WithParamInterface<ModelCase> {};

// Pixels whose neighbours show another object are edges, whatever msaa4 takes for one.
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
  Settings settings = multisampled(kWidth, kHeight);
  settings.countSurfaces = true;
  const Values surfaces = color(renderer, camera, settings);
  const ShadingCounts counts = renderer.shadingCounts().value();
  settings.everySample = true;
  const Values samples = color(renderer, camera, settings);
  settings = settingsOf(kWidth, kHeight, {Aov::Color, Aov::Part});
  const output::FrameOutput plain = std::move(renderer.render({&camera, 1}, settings).front());
  const Values& none = imageOf(plain, Aov::Color).values;
  settings.aovs = {Aov::Color};
  settings.aa.superSampling = 4;
  const Values sixteen = color(renderer, camera, settings);

  const std::vector<bool> edge = edges(imageOf(plain, Aov::Part));
  double off = 0, errorNone = 0, error4 = 0, errorEvery = 0;
  size_t count = 0;
  for (size_t i = 0; i < edge.size(); ++i) {
    off += difference(surfaces, samples, i);
    if (!edge[i]) continue;
    ++count;
    errorNone += std::pow(difference(none, sixteen, i), 2);
    error4 += std::pow(difference(surfaces, sixteen, i), 2);
    errorEvery += std::pow(difference(samples, sixteen, i), 2);
  }
  off /= static_cast<double>(edge.size());
  const double share = static_cast<double>(counts.several) / static_cast<double>(counts.drawn);
  const auto psnr = [&](double error) { return -10 * std::log10(error / static_cast<double>(count)); };
  fmt::print(
      "{}: {:.1f} % of the drawn pixels shaded per sample, {:.3f} shadings a pixel; from every sample {:.5f} off\n",
      name, 100 * share, static_cast<double>(counts.shadings) / static_cast<double>(counts.drawn), off);
  fmt::print(
      "  {} edge pixels against ss4: none {:.2f} dB, msaa4 {:.2f} dB, every sample {:.2f} dB; better by {:.2f}\n",
      count, psnr(errorNone), psnr(error4), psnr(errorEvery), errorNone / error4);
  EXPECT_GT(count, 200u);
  EXPECT_LT(share, GetParam().mostShare);
  EXPECT_LT(off, GetParam().mostOff);
  EXPECT_GT(errorNone / error4, GetParam().leastBetter);
  EXPECT_LT(psnr(errorEvery) - psnr(error4), 1);
}

std::vector<ModelCase> modelCases() {
  std::vector<ModelCase> cases{{"hall", 0.45, 0.004, 3}, {"spheres", 0.1, 0.004, 5}, {"textured.glb", 0.1, 0.001, 5}};
  if (!models::withReal({}, {"DamagedHelmet.glb"}).empty()) cases.push_back({"DamagedHelmet.glb", 0.5, 0.002, 5});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, MsaaModels, testing::ValuesIn(modelCases()), [](const auto& info) {
  std::string name = info.param.name;
  return name.substr(0, name.find('.'));
});

}  // namespace
}  // namespace latelight::render::test
