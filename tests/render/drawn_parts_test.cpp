// On a CPU device, many triangles are drawn by several renderings (ViewRendering). The code paths for GPUs, on the same
// device, draw all of them by one and show the same triangles.
#include <fmt/core.h>

#include "render/support.h"
#include "scene/edit.h"

namespace latelight::render::test {
namespace {

using output::Aov;

// Spheres of one draw with several instances: some have more triangles than a rendering, and some less. Two of the
// former coincide, and the surface drawn last is visible. `materials`: more than 16 prevent resolving by groups.
scene::Scene spheres(uint32_t materials, uint32_t flags) {
  scene::SceneBuilder builder("spheres");
  scene::Scene& scene = builder.scene;
  scene.meshes = {sphereMesh(0.3f, 60), sphereMesh(0.04f, 7)};
  for (uint32_t i = 0; i < materials; ++i) {
    scene.materials.push_back(scene::plainMaterial("m", {0.9f, 0.6f, 0.3f}, 0, 0.5f));
    scene.materials.back().data.id = i + 1;
    scene.materials.back().data.flags |= flags;
  }
  const auto place = [&](uint32_t mesh, uint32_t material, const glm::vec3& at) {
    builder.addInstance("sphere", builder.kRoot, mesh, material, glm::translate(glm::mat4(1), at));
  };
  for (int i = -2; i <= 2; ++i) place(0, 0, {0.4f * float(i), 0.3f * float(i), 0.2f * float(i)});
  for (uint32_t material : {0, 1}) place(0, material, {0.6f, -0.6f, 0});
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      place(1, uint32_t(x) % materials, {0.15f * float(x) - 0.8f, 0.15f * float(y) - 0.8f, 0.4f});
  for (int i = 0; i < 3; ++i) {
    scene::Light& light = scene.lights.emplace_back();
    light.type = shared::kLightPoint;
    light.position = {0.7f * float(i - 1), -2, 0.5f};
    light.intensity = 4;
  }
  return std::move(scene);
}

class DrawnParts : public RenderTest {};

TEST_F(DrawnParts, ShowTheSameTriangles) {
  if (!device().hasGraphics()) GTEST_SKIP() << "the device has no graphics pipeline";
  const std::vector<Aov> aovs = {Aov::Depth, Aov::Id, Aov::Material, Aov::Triangle};
  const std::vector<scene::Camera> cameras = {frontCamera(), frontPerspective(0.6f, 3)};
  for (const uint32_t materials : {2u, 17u})
    for (const uint32_t flags : {0u, shared::kMaterialDoubleSided, shared::kMaterialMasked}) {
      SCOPED_TRACE(fmt::format("{} materials, flags {}", materials, flags));
      const scene::Scene scene = spheres(materials, flags);
      Settings settings = settingsOf(181, 97, aovs);
      settings.raster = Raster::Hardware;
      const auto some = Renderer(device(), scene, nullptr).render(cameras, settings);
      const auto every = Renderer(gpuPaths(), scene, nullptr).render(cameras, settings);
      for (size_t view = 0; view < cameras.size(); ++view)
        for (size_t i = 0; i < aovs.size(); ++i) {
          const output::AovImage &a = some[view].aovs[i], &b = every[view].aovs[i];
          EXPECT_TRUE(a.values == b.values && a.ids == b.ids) << output::info(aovs[i]).name << ", view " << view;
        }
    }
}

// forward-multipass finds the triangles of its first pass again in those of each light.
TEST_F(DrawnParts, AreLitByEachLight) {
  if (!device().hasGraphics()) GTEST_SKIP() << "the device has no graphics pipeline";
  const scene::Scene scene = spheres(2, 0);
  const scene::Camera camera = frontCamera();
  Renderer renderer(device(), scene, nullptr);
  const auto colorsBy = [&](const char* technique) {
    Settings settings = settingsOf(181, 97, {Aov::Color});
    settings.raster = Raster::Hardware;
    settings.lighting = &findTechnique(technique);
    return imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
  };
  const std::vector<float> expected = colorsBy("fullscreen");
  for (const char* technique : {"forward", "forward-multipass", "volumes"}) {
    const std::vector<float> colors = colorsBy(technique);
    for (size_t i = 0; i < colors.size(); ++i)
      ASSERT_NEAR(colors[i], expected[i], 2e-3f) << technique << ", value " << i;
  }
}

}  // namespace
}  // namespace latelight::render::test
