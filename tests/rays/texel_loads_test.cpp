// On CPU devices, rays load the scene as texels. What does not fit in the texel window is loaded by address, with the
// same results.
#include <glm/gtc/matrix_transform.hpp>

#include "models/models.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "vk/memory.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class TexelLoads : public RenderTest {
 protected:
  // Buffers that fill the texel window, so that further ones lie outside.
  static std::vector<vk::Buffer> fillers() {
    std::vector<vk::Buffer> all;
    for (VkDeviceSize size = VkDeviceSize{1} << 30; device().memory().isAllInWindow(); size /= 2)
      all.emplace_back(device(), vk::BufferDesc{.size = size, .name = "filler"});
    return all;
  }
};

TEST_F(TexelLoads, GiveTheSameBytesAsLoadsByAddress) {
  if (!device().memory().window()) GTEST_SKIP() << device().info().name << " has no texel window";
  const scene::Scene scene = scene::load(models::modelPath("textured.glb"));
  const scene::Camera camera = cameraOf(scene, 40, 24);
  const auto images = [&] {
    std::vector<std::pair<std::vector<float>, std::vector<uint32_t>>> values;
    for (const Raster raster : {Raster::Hardware, Raster::Rays}) {
      Settings settings = settingsOf(40, 24, {Aov::Color, Aov::Depth, Aov::Id});
      settings.lighting = &findTechnique(raster == Raster::Hardware ? "reference" : "clustered");
      settings.raster = raster;
      settings.samples = 2;
      settings.shadows = ShadowFormat::Rays;
      settings.indirect = raster == Raster::Rays ? Indirect::Path : Indirect::None;
      for (const output::AovImage& image : renderOne(device(), scene, camera, settings).aovs)
        values.emplace_back(image.values, image.ids);
    }
    return values;
  };
  const auto inWindow = images();
  const std::vector<vk::Buffer> outside = fillers();
  EXPECT_EQ(images(), inWindow);
}

// Recorded commands fetch texels, but the scene's arrays have moved out of the window.
TEST_F(TexelLoads, RequestsAreRecordedAgainWhenTheWindowIsFull) {
  if (!device().memory().window()) GTEST_SKIP() << device().info().name << " has no texel window";
  scene::Scene scene = scene::load(models::modelPath("textured.glb"));
  const scene::Camera camera = cameraOf(scene, 40, 24);
  Settings settings = settingsOf(40, 24, {Aov::Color, Aov::Depth, Aov::Id});
  settings.raster = Raster::Rays;
  Renderer renderer(device(), scene, nullptr);
  for (int call = 0; call < 4; ++call) renderer.render({&camera, 1}, settings);
  const std::vector<vk::Buffer> outside = fillers();
  for (int i = 0; i < 100; ++i)
    scene::addInstance(scene, 0, 0, glm::translate(glm::dmat4(1), glm::dvec3(0, 0.02 * i, 0)));
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
  const output::FrameOutput fresh = renderOne(device(), scene, camera, settings);
  for (size_t i = 0; i < frame.aovs.size(); ++i) {
    EXPECT_EQ(frame.aovs[i].values, fresh.aovs[i].values) << i;
    EXPECT_EQ(frame.aovs[i].ids, fresh.aovs[i].ids) << i;
  }
}

}  // namespace
}  // namespace latelight::render::test
