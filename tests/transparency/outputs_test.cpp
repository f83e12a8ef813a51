// Every output of a scene in which the only surface with an alpha mode other than opaque is blended.
#include <cmath>

#include "render/settings/settings.h"
#include "render/support.h"
#include "transparency/scenes.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class OutputsBesideGlass : public RenderTest {
 protected:
  scene::Scene scene = sceneOf({ColoredTriangle{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {1, 0, 0, 0.5f}}});
  scene::Camera camera = frontCamera();
};

// Each output by itself, so that no pass for another one creates what it lacks; then again, when nothing needs to be
// compiled.
TEST_F(OutputsBesideGlass, AreThereOneByOne) {
  Renderer renderer(device(), scene, nullptr);
  for (const NamedOption& surfaces : choices<DataSurfaces>())
    for (const NamedOption& method : choices<TransparencyMethod>())
      for (const output::AovInfo& aov : output::aovs()) {
        SCOPED_TRACE(std::string(aov.name) + " of " + surfaces.name + " surfaces, " + method.name);
        Settings settings = settingsOf(9, 7, {aov.aov});
        settings.dataSurfaces = choiceNamed<DataSurfaces>(surfaces.name).value();
        settings.transparency = choiceNamed<TransparencyMethod>(method.name).value();
        const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
        for (const float value : imageOf(frame, aov.aov).values)
          EXPECT_TRUE(std::isfinite(value) || value == aov.background);
        const uint64_t pipelines = device().pipelinesMade();
        const output::FrameOutput again = std::move(renderer.render({&camera, 1}, settings).front());
        EXPECT_EQ(device().pipelinesMade(), pipelines);
        EXPECT_EQ(imageOf(again, aov.aov).values, imageOf(frame, aov.aov).values);
      }
}

TEST_F(OutputsBesideGlass, AndTheLayoutsTargets) {
  Renderer renderer(device(), scene, nullptr);
  EXPECT_FALSE(renderer.readTargets(camera, settingsOf(9, 7)).gbuffer.targets.empty());
}

// A picture and its counts alternate; each keeps its pipelines.
TEST_F(OutputsBesideGlass, TakeTurnsWithoutPipelinesMadeAnew) {
  Renderer renderer(device(), scene, nullptr);
  const Settings settings = settingsOf(9, 7, {Aov::Color, Aov::LightsTested, Aov::Samples, Aov::Motion});
  renderer.render({&camera, 1}, settings);
  const uint64_t pipelines = device().pipelinesMade();
  for (int frame = 0; frame < 3; ++frame) renderer.render({&camera, 1}, settings);
  EXPECT_EQ(device().pipelinesMade(), pipelines);
}

}  // namespace
}  // namespace latelight::render::test
