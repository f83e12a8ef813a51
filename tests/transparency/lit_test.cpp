// Blended surfaces under lights: they are lit like opaque ones, independently of the technique that lights the rest of
// the picture, equally with the light tree and with all lights, and with buffers that grow.
#include <fmt/core.h>

#include "base/error.h"
#include "render/base/readback.h"
#include "render/base/registry.h"
#include "render/frame/view.h"
#include "render/frame_bench.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/submit/frame_passes.h"
#include "render/transparency/transparency.h"
#include "shared/light.h"
#include "shared/random.h"
#include "transparency/scenes.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kWidth = 80, kHeight = 48;

// Spheres and panes with every kind of blended material in front of the background, and one in front of a wall.
scene::Scene glassRoom(uint32_t lights) {
  scene::SceneBuilder builder("glass");
  scene::Scene& scene = builder.scene;
  scene.meshes = {squareMesh(), sphereMesh(0.8f)};
  const auto material = [&](vec4 color, float metallic, float roughness) -> shared::Material& {
    scene::Material& m = scene.materials.emplace_back(scene::plainMaterial("m", vec3(color), metallic, roughness));
    m.data.baseColor.a = color.a;
    m.data.flags |= color.a < 1 ? shared::kMaterialBlended : 0u;
    return m.data;
  };
  const auto place = [&](uint32_t mesh, vec3 at, vec3 size) {
    builder.addInstance("thing", 0, mesh, static_cast<uint32_t>(scene.materials.size()) - 1,
                        glm::scale(glm::translate(glm::mat4(1), at), size));
  };
  material({0.7f, 0.6f, 0.5f, 1}, 0, 0.6f);
  place(0, {1.6f, 0, -1.5f}, {0.9f, 2, 1});
  material({0.9f, 0.3f, 0.2f, 0.5f}, 0, 0.4f).flags |= shared::kMaterialDoubleSided;
  place(1, {-1.2f, 0.2f, 0}, vec3(1));
  material({0.2f, 0.5f, 0.9f, 0.6f}, 1, 0.3f);
  place(1, {-0.4f, -0.3f, 0.5f}, vec3(0.9f));
  material({0.1f, 0.1f, 0.1f, 0.4f}, 0, 0.4f).emissive = {0.4f, 0.3f, 0.1f};
  place(1, {1.2f, 0.4f, 0.3f}, vec3(0.8f));
  material({0.3f, 0.8f, 0.4f, 0.3f}, 0, 0.5f).flags |= shared::kMaterialUnlit;
  place(0, {0.2f, 0, 0.9f}, {1.4f, 0.3f, 1});
  shared::Random random(21);
  for (uint32_t i = 0; i < lights; ++i) {
    scene::Light& light = scene.lights.emplace_back();
    light.type = i % 7 == 0 ? shared::kLightDirectional : i % 3 ? shared::kLightPoint : shared::kLightSpot;
    light.position = {random.uniform(-2.5f, 2.5f), random.uniform(-2.5f, 1), random.uniform(-1.5f, 1.5f)};
    light.direction = glm::normalize(vec3(random.uniform(-1, 1), 1, random.uniform(-1, 1)));
    light.color = {random.uniform(0.3f, 1), random.uniform(0.3f, 1), random.uniform(0.3f, 1)};
    light.intensity = light.type == shared::kLightDirectional ? 2.0f / static_cast<float>(lights) : 0.3f;
    light.outerCone = 0.6f;
    if (light.type != shared::kLightDirectional) light.range = random.uniform(0.3f, 1.5f);
  }
  return std::move(scene);
}

// --- frames with their own setup ------------------------------------------------------------------------------------

class Bench {
 public:
  Bench(vk::Device& device, const scene::Scene& scene) : frames_(device, scene) {}

  struct Result {
    std::vector<uint16_t> halves;  // RGBA
    uint32_t runs = 0;
  };
  // With this initial capacity for fragments.
  Result render(const TransparencySetup& transparency, uint64_t fragments = 0) {
    const FrameConfig setup{
        .layout = &findLayout("thin"), .lighting = &findTechnique("fullscreen"), .transparency = transparency};
    const shared::View view = makeView(frontPerspective(0.9f, 4), kWidth, kHeight);
    Overflow overflow{.fragments = fragments};
    Result result;
    for (;;) {
      graph::Graph graph;
      const graph::BufferId picture =
          addReadback(graph, addFrame(frames_.frame(graph, setup, {view}, {}, &overflow)).picture);
      const graph::Submission& done = frames_.run(graph);
      ++result.runs;
      if (overflowed(std::exchange(overflow.checks, {}), done)) continue;
      const uint16_t* halves = done.buffer(picture).as<uint16_t>();
      result.halves.assign(halves, halves + size_t{4} * kWidth * kHeight);
      return result;
    }
  }

 private:
  FrameBench frames_;
};

class LitGlass : public RenderTest {};

// Starts with a capacity of one fragment: the overflow is detected, the buffer grows, and the picture equals that of
// ample capacity.
TEST_F(LitGlass, MemoryGrowsUntilAllFits) {
  const scene::Scene scene = glassRoom(20);
  Bench bench(device(), scene);
  const Bench::Result ample = bench.render({}, 1 << 20), tight = bench.render({}, 1);
  EXPECT_EQ(ample.runs, 1u);
  EXPECT_EQ(tight.runs, 2u);
  EXPECT_EQ(tight.halves, ample.halves);
  EXPECT_EQ(bench.render({}, 1 << 20).halves, ample.halves);  // the same bytes again
}

// If the device has no more memory, the error names a remedy; a picture is never incomplete.
TEST_F(LitGlass, MemoryThatEndsIsSaid) {
  const scene::Scene scene = glassRoom(1);
  Bench bench(device(), scene);
  try {
    bench.render({.most = 100}, 1);
    ADD_FAILURE() << "100 fragments were enough";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::OutOfMemory);
    for (const char* part : {"fragments of 28 bytes", "at most 100", "sorted or weighted"})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST_F(LitGlass, TheLightTreeLeavesNoLightOut) {
  const scene::Scene scene = glassRoom(400);
  Bench bench(device(), scene);
  for (uint32_t method : {kTransparencyExact, kTransparencySorted}) {
    const std::vector<uint16_t> tree = bench.render({.method = method}).halves;
    const std::vector<uint16_t> every = bench.render({.method = method, .everyLight = true}).halves;
    int worst = 0;  // in steps of a half float
    for (size_t i = 0; i < tree.size(); ++i) worst = std::max(worst, std::abs(int{tree[i]} - int{every[i]}));
    EXPECT_LE(worst, 1) << method;
  }
}

// --- with other features
// ---------------------------------------------------------------------------------------------

std::vector<float> colorOf(Renderer& renderer, const Settings& settings) {
  const scene::Camera camera = frontPerspective(0.9f, 4);
  return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
}

// If nothing opaque is behind, the result is equal byte for byte; otherwise the layout's version of the wall is visible
// through it.
TEST_F(LitGlass, IsAlikeWithEveryTechniqueAndLayout) {
  const scene::Scene scene = glassRoom(20);
  Renderer renderer(device(), scene, nullptr);
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
  settings.layout = &findLayout("exact");
  const std::vector<float> expected = colorOf(renderer, settings);
  size_t glassAlone = 0;
  const auto compare = [&] {
    SCOPED_TRACE(settings.lighting->name + ", " + settings.layout->name);
    const std::vector<float> picture = colorOf(renderer, settings);
    for (size_t i = 0; i < picture.size(); i += 4) {
      const bool alone = expected[i + 3] > 0 && expected[i + 3] < 0.999f;
      glassAlone += alone;
      for (size_t c = 0; alone && c < 4; ++c) ASSERT_EQ(picture[i + c], expected[i + c]) << i;
      ASSERT_NEAR(picture[i + 3], expected[i + 3], 1e-3) << i;
    }
  };
  for (const TechniqueInfo& technique : techniques()) {
    settings.lighting = &technique;
    if (rastersInCompute(settings) == (settings.raster == Raster::Compute)) compare();
  }
  settings.lighting = &findTechnique("tiled");
  for (const Layout* layout : layoutsToMeet()) {
    settings.layout = layout;
    compare();
  }
  EXPECT_GT(glassAlone, (techniques().size() + layoutsToMeet().size()) * kWidth * kHeight / 20);
}

// As alpha approaches 1, at which materials count as opaque, the picture approaches that of the same materials
// unblended, in both shading models and with an environment.
TEST_F(LitGlass, WithAlphaOneIsTheOpaqueSurface) {
  scene::Scene scene = glassRoom(20);
  scene::Scene opaque = glassRoom(20);
  for (scene::Material& material : scene.materials) {
    material.data.baseColor.a = std::nextafter(1.0f, 0.0f);
    material.data.flags |= shared::kMaterialBlended;
  }
  for (scene::Material& material : opaque.materials) material.data.flags &= ~shared::kMaterialBlended;
  const scene::Environment environment = constantEnvironment();
  Renderer blended(device(), scene, &environment), solid(device(), opaque, &environment);
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
  settings.lighting = &findTechnique("forward");
  for (const NamedOption& shading : choices<Shading>()) {
    settings.shading = choiceNamed<Shading>(shading.name).value();
    const std::vector<float> expected = colorOf(solid, settings), picture = colorOf(blended, settings);
    for (size_t i = 0; i < picture.size(); ++i)
      ASSERT_NEAR(picture[i], expected[i], 1.0 / 255 * std::max(1.0f, expected[i])) << shading.name << " " << i;
  }
}

// Several cameras of one frame have separate lists.
TEST_F(LitGlass, ViewsTogetherAreViewsAlone) {
  const scene::Scene scene = glassRoom(5);
  Renderer renderer(device(), scene, nullptr);
  std::vector<scene::Camera> cameras{frontPerspective(0.9f, 4), frontCamera(2), frontPerspective(0.5f, 6)};
  for (const char* method : {"exact", "sorted", "weighted"}) {
    SCOPED_TRACE(method);
    Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
    settings.transparency = choiceNamed<TransparencyMethod>(method).value();
    const auto together = renderer.render(cameras, settings);
    for (size_t i = 0; i < cameras.size(); ++i)
      EXPECT_EQ(imageOf(together[i], Aov::Color).values,
                imageOf(renderer.render({&cameras[i], 1}, settings).front(), Aov::Color).values);
    EXPECT_NE(imageOf(together[0], Aov::Color).values, imageOf(together[1], Aov::Color).values);
  }
}

}  // namespace
}  // namespace latelight::render::test
