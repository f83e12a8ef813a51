// Surfaces with layered materials, which are shaded after the G-buffer: they are independent of layout, technique,
// raster and number of views or strips. Coats of zero strength result in the plain surface, and an edited scene equals
// a newly loaded one.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "layers/scenes.h"
#include "long_tests.h"
#include "render/gbuffer/layout.h"
#include "render/submit/strips.h"
#include "scene/edit.h"

namespace latelight::render::test {
namespace {

using output::Aov;
using Values = std::vector<float>;

constexpr uint32_t kWidth = 112, kHeight = 70;

class Layered : public RenderTest {
 protected:
  static Settings picture(std::vector<Aov> aovs = {Aov::Color}) { return settingsOf(kWidth, kHeight, std::move(aovs)); }
  static Values colorOf(Renderer& renderer, const Settings& settings) {
    const scene::Camera camera = roomCamera();
    return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
  }
  // For each pixel, the index of its layered material among the room's materials, or -1.
  static std::vector<int> layeredPixels(Renderer& renderer, const scene::Scene& scene) {
    const scene::Camera camera = roomCamera();
    const output::FrameOutput frame = renderer.render({&camera, 1}, picture({Aov::Material})).front();
    std::vector<int> shown;
    for (const uint32_t id : imageOf(frame, Aov::Material).ids) {
      const auto found = std::ranges::find(scene.materials, id, [](const scene::Material& m) { return m.data.id; });
      const bool layered = found != scene.materials.end() && scene::layerFlags(found->data) != 0;
      shown.push_back(layered ? static_cast<int>(found - scene.materials.begin()) : -1);
    }
    return shown;
  }
};

// The materials of a room have ids in these tests, which identify their pixels.
scene::Scene identifiedRoom() {
  scene::Scene scene = layeredRoom();
  for (uint32_t i = 0; i < scene.materials.size(); ++i) scene.materials[i].data.id = i + 1;
  return scene;
}

TEST_F(Layered, EveryTechniqueAndLayoutGivesTheSameBytes) {
  // test_render covers how these shaders find lights.
  if (std::getenv("LATELIGHT_TEST_GPU_SHADERS")) LATELIGHT_SKIP_UNLESS_ALL();
  const scene::Scene scene = identifiedRoom();
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  const std::vector<int> shown = layeredPixels(renderer, scene);
  for (int kind = 2; kind < static_cast<int>(scene.materials.size()); ++kind)
    EXPECT_GT(std::ranges::count(shown, kind), 40) << kind;
  Settings settings = picture();
  settings.shadows = choiceNamed<ShadowFormat>("d32").value();
  const Values expected = colorOf(renderer, settings);
  const auto compare = [&] {
    const Values found = colorOf(renderer, settings);
    for (size_t i = 0; i < shown.size(); ++i)
      for (size_t c = 0; shown[i] >= 0 && c < 4; ++c)
        ASSERT_EQ(found[4 * i + c], expected[4 * i + c]) << settings.lighting->name << " " << settings.layout->name;
  };
  for (const TechniqueInfo& technique : techniques()) {
    settings.lighting = &technique;
    if (rastersInCompute(settings) == (settings.raster == Raster::Compute)) compare();
  }
  settings.lighting = &findTechnique("clustered");
  for (const Layout* layout : layoutsToMeet()) {
    settings.layout = layout;
    compare();
  }
}

// Both rasters, which round positions differently, as for plain surfaces. With several samples per pixel, edges must
// agree too: both shade each triangle at the centroid of its samples.
TEST_F(Layered, BothRastersAgree) {
  const scene::Scene scene = identifiedRoom();
  Renderer renderer(device(), scene, nullptr);
  const std::vector<int> shown = layeredPixels(renderer, scene);
  for (const uint32_t samples : {1u, 4u}) {
    SCOPED_TRACE(samples);
    Settings settings = picture();
    settings.aa.samples = samples;
    settings.raster = Raster::Hardware;
    const Values drawn = colorOf(renderer, settings);
    settings.raster = Raster::Compute;
    const Values found = colorOf(renderer, settings);
    double sum = 0;
    size_t layered = 0, far = 0;
    for (size_t i = 0; i < shown.size(); ++i) {
      if (shown[i] < 0) continue;
      ++layered;
      for (size_t c = 0; c < 3; ++c) {
        const double difference = std::abs(drawn[4 * i + c] - found[4 * i + c]);
        sum += difference;
        far += difference > 0.02 * std::max(1.0f, drawn[4 * i + c]);
      }
    }
    fmt::print("{} samples: {:.5f} in the mean, {} of {} far\n", samples, sum / (3.0 * double(layered)), far, layered);
    EXPECT_LT(sum / (3.0 * static_cast<double>(layered)), samples == 1 ? 5e-4 : 1e-3);
    EXPECT_LE(far, samples == 1 ? layered / 1000 : layered / 25);
  }
}

// A texture of zeros removes every layer's strength, but the surface is still shaded as a layered one.
TEST_F(Layered, WithoutStrengthIsThePlainPicture) {
  scene::Scene scene = layeredRoom();
  scene.textures.push_back(textureOf(1, 1, false, {glm::u8vec4(0)}));
  scene::Scene plain = layeredRoom();
  for (uint32_t i = 2; i < scene.materials.size(); ++i) {
    scene::Material& m = scene.materials[i];
    for (const uint32_t slot : {shared::kTextureClearcoat, shared::kTextureSheenColor, shared::kTextureAnisotropy,
                                shared::kTextureIridescence, shared::kTextureDiffuseTransmission})
      setTexture(m, slot, 1);
    plain.materials[i].data.layers = scene::noLayers();
  }
  const scene::Environment environment = constantEnvironment();
  // Visibility and shading are independent of each other, so the default shading suffices for the compute raster.
  const auto shadings = choices<Shading>().first(testRaster() == Raster::Compute ? 1 : choices<Shading>().size());
  for (const NamedOption& shading : shadings) {
    Settings settings = picture();
    settings.shading = choiceNamed<Shading>(shading.name).value();
    settings.layout = &findLayout("exact");
    Renderer layered(device(), scene, &environment), bare(device(), plain, &environment);
    const Values found = colorOf(layered, settings), expected = colorOf(bare, settings);
    size_t different = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      ASSERT_NEAR(found[i], expected[i], 2e-3 * std::max(1.0f, expected[i])) << shading.name << " " << i;
      different += found[i] != expected[i];
    }
    EXPECT_LT(different, found.size() / 50) << shading.name;
  }
}

// Factors of 0 add no layers: the picture equals that of a scene without layers, and the passes are the same.
TEST_F(Layered, FactorsOfZeroAreNoLayers) {
  scene::Scene scene = layeredRoom(), plain = layeredRoom();
  for (scene::Material& m : scene.materials) {
    shared::MaterialLayers& l = m.data.layers;
    l.clearcoat = l.anisotropy = l.iridescence = l.transmission = l.diffuseTransmission = 0;
    l.sheenColor = vec3(0);
    l.clearcoatRoughness = 0.3f, l.thickness = 2, l.dispersion = 4;
  }
  for (scene::Material& m : plain.materials) m.data.layers = scene::noLayers();
  Renderer layered(device(), scene, nullptr), bare(device(), plain, nullptr);
  EXPECT_EQ(colorOf(layered, picture()), colorOf(bare, picture()));
}

TEST_F(Layered, LayersShow) {
  const scene::Scene scene = identifiedRoom();
  scene::Scene plain = identifiedRoom();
  for (scene::Material& m : plain.materials) m.data.layers = scene::noLayers();
  const scene::Environment environment = constantEnvironment();
  Renderer layered(device(), scene, &environment), bare(device(), plain, &environment);
  const std::vector<int> shown = layeredPixels(layered, scene);
  const Values with = colorOf(layered, picture()), without = colorOf(bare, picture());
  std::vector<double> difference(scene.materials.size());
  for (size_t i = 0; i < shown.size(); ++i)
    for (size_t c = 0; shown[i] >= 0 && c < 3; ++c)
      difference[static_cast<size_t>(shown[i])] += std::abs(with[4 * i + c] - without[4 * i + c]);
  for (size_t kind = 2; kind < scene.materials.size(); ++kind)
    EXPECT_GT(difference[kind] / (3.0 * static_cast<double>(std::ranges::count(shown, static_cast<int>(kind)))), 0.005)
        << kind;
}

TEST_F(Layered, StripsAreTheWholePicture) {
  const scene::Scene scene = layeredRoom();
  Renderer renderer(device(), scene, nullptr);
  Settings settings = settingsOf(96, 200, {Aov::Color});
  const Values whole = colorOf(renderer, settings);
  settings.stripPixels = 96 * 100;
  ASSERT_GT(stripsOf(settings).size(), 1u);
  const Values parted = colorOf(renderer, settings);
  size_t different = 0;
  for (size_t i = 0; i < whole.size(); ++i)
    different += std::abs(whole[i] - parted[i]) > 4e-3f * std::max(1.0f, whole[i]);
  EXPECT_LE(different, whole.size() / 1000);  // in highlights, because positions are rounded
}

TEST_F(Layered, ViewsTogetherAreViewsAlone) {
  const scene::Scene scene = layeredRoom();
  Renderer renderer(device(), scene, nullptr);
  const std::vector<scene::Camera> cameras{roomCamera(), frontCamera(2), frontPerspective(0.5f, 6)};
  const auto together = renderer.render(cameras, picture());
  for (size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(imageOf(together[i], Aov::Color).values,
              imageOf(renderer.render({&cameras[i], 1}, picture()).front(), Aov::Color).values);
}

// A lens without distortion shows what a pinhole camera does, except for the rounding of positions.
TEST_F(Layered, ALensWithoutDistortionIsAPinhole) {
  const scene::Scene scene = identifiedRoom();
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  const std::vector<int> shown = layeredPixels(renderer, scene);
  Settings settings = picture();
  settings.raster = Raster::Compute;
  const Values pinhole = colorOf(renderer, settings);
  scene::Camera camera = roomCamera();
  const double focal = 0.5 * kHeight / std::tan(0.5 * double{camera.verticalFov});
  camera.lens = scene::Lens{scene::LensModel::OpenCv, kWidth, kHeight, focal, focal, 0.5 * kWidth, 0.5 * kHeight};
  const Values found = imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
  size_t layered = 0, far = 0;
  for (size_t i = 0; i < shown.size(); ++i)
    for (size_t c = 0; shown[i] >= 0 && c < 3; ++c, ++layered)
      far += std::abs(found[4 * i + c] - pinhole[4 * i + c]) > 0.01f * std::max(1.0f, pinhole[4 * i + c]);
  EXPECT_GT(layered, 1000u);
  EXPECT_LE(far, layered / 100);
}

// Edges of layered surfaces are antialiased as well as those of plain ones, compared with 16 samples per pixel.
TEST_F(Layered, SamplesSmoothEdges) {
  const scene::Scene scene = layeredRoom();
  Renderer renderer(device(), scene, nullptr);
  Settings settings = picture();
  const Values rough = colorOf(renderer, settings);
  settings.aa.superSampling = 4;
  const Values reference = colorOf(renderer, settings);
  const auto error = [&](const Values& values) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i)
      sum += std::abs(std::min(values[i], 1.0f) - std::min(reference[i], 1.0f));
    return sum / static_cast<double>(values.size());
  };
  for (const AntiAliasing& aa : {AntiAliasing{.samples = 4}, AntiAliasing{.temporal = true}}) {
    settings.aa = aa;
    EXPECT_LT(error(colorOf(renderer, settings)), 0.6 * error(rough)) << aa.samples;
  }
}

// An edit adds, changes and removes a layer. Each picture equals that of a new renderer.
TEST_F(Layered, EditsAreAFreshLoad) {
  scene::Scene scene = layeredRoom();
  for (scene::Material& m : scene.materials) m.data.layers = scene::noLayers();
  Renderer renderer(device(), scene, nullptr);
  const Values before = colorOf(renderer, picture());
  const auto edited = [&](const scene::Material& material) {
    scene::setMaterial(scene, 1, material);
    const Values found = colorOf(renderer, picture());
    Renderer fresh(device(), scene, nullptr);
    EXPECT_EQ(found, colorOf(fresh, picture()));
    return found;
  };
  const scene::Material plain = scene.materials[1], other = scene.materials[2];
  scene::Material coated = plain;
  coated.data.layers.clearcoat = 1;
  const Values coat = edited(coated);
  EXPECT_NE(coat, before);
  // With the same layers as before, but other strengths and materials.
  const uint64_t pipelines = device().pipelinesMade();
  scene::Material worn = coated;
  worn.data.layers.clearcoat = 0.5f, worn.data.layers.clearcoatRoughness = 0.3f;
  EXPECT_NE(edited(worn), coat);
  worn.data.baseColor = {0.1f, 0.2f, 0.6f, 1};
  scene::setMaterial(scene, 2, worn);
  EXPECT_NE(edited(coated), coat);
  scene::setMaterial(scene, 2, other);
  EXPECT_EQ(edited(coated), coat);
  EXPECT_EQ(device().pipelinesMade(), pipelines);
  scene::Material glass = coated;
  glass.data.layers.transmission = 1;
  EXPECT_NE(edited(glass), coat);
  EXPECT_EQ(edited(plain), before);
}

}  // namespace
}  // namespace latelight::render::test
