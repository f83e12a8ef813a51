// Edge cases of edits: before the first frame, without any element, of all elements, of animated properties, and with
// two renderers.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "edits/workshop.h"
#include "models/models.h"
#include "scene/edit.h"
#include "scene/framing.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using scene::addInstance;
using scene::addLight;
using scene::removeInstance;
using scene::removeLight;
using scene::setMesh;
using scene::setTransform;

glm::mat4 standing(vec3 at, float size) {
  return glm::scale(glm::translate(glm::mat4(1), at), vec3(size));
}

class EditCasesTest : public RenderTest {
 protected:
  scene::Scene scene_ = workshop();
  const Settings settings_ = workshopSettings();
};

TEST_F(EditCasesTest, BeforeTheFirstFrame) {
  Renderer renderer(device(), scene_, nullptr);
  setTransform(scene_, 1, standing({0, -1, 0.5f}, 1));
  addInstance(scene_, 0, 3, standing({0.5f, -1, 0.5f}, 0.7f));
  removeInstance(scene_, 0);
  removeLight(scene_, 1);
  setMesh(scene_, 1, sphereMesh(0.3f));
  expectAsFresh(renderer, device(), scene_, settings_);
}

// Each renderer follows the edits when it renders.
TEST_F(EditCasesTest, TwoRenderersOnOneScene) {
  Renderer often(device(), scene_, nullptr), seldom(device(), scene_, nullptr);
  for (uint32_t i = 0; i < 6; ++i) {
    setTransform(scene_, i, standing({float(i) - 3, -1, 0.5f}, 1));
    addLight(scene_, scene_.lights[1]);
    removeInstance(scene_, 8 - i % 2);
    addInstance(scene_, i % 3, i, standing({1, float(i), 1}, 0.5f));
    expectAsFresh(often, device(), scene_, settings_);
  }
  expectAsFresh(seldom, device(), scene_, settings_);
}

// With every lighting technique, none of which may depend on an element that does not exist.
TEST_F(EditCasesTest, RemovingEverythingAndPuttingSomethingBack) {
  Renderer renderer(device(), scene_, nullptr);
  expectAsFresh(renderer, device(), scene_, settings_);
  for (uint32_t i = 0; i < scene_.lights.size(); ++i) removeLight(scene_, i);
  expectAsFresh(renderer, device(), scene_, settings_);
  for (uint32_t i = 0; i < scene_.instances.size(); ++i) removeInstance(scene_, i);
  expectAsFresh(renderer, device(), scene_, settings_);
  const scene::Light lamp = workshop().lights[2];
  addLight(scene_, lamp);
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    Settings settings = settings_;
    settings.lighting = &technique;
    expectAsFresh(renderer, device(), scene_, settings);
  }
  addInstance(scene_, 0, 0, standing({0, 0, 1}, 1));
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    Settings settings = settings_;
    settings.lighting = &technique;
    expectAsFresh(renderer, device(), scene_, settings);
  }
}

TEST_F(EditCasesTest, ASceneThatBeginsEmpty) {
  scene::Scene scene;
  scene.name = scene.source = "empty";
  Renderer renderer(device(), scene, nullptr);
  expectAsFresh(renderer, device(), scene, settings_);
  const uint32_t mesh = scene::addMesh(scene, sphereMesh(1));
  const uint32_t material = scene::addMaterial(scene, scene::plainMaterial("new", vec3(1), 0, 0.5f));
  expectAsFresh(renderer, device(), scene, settings_);
  addInstance(scene, mesh, material, standing({0, 0, 1}, 1));
  expectAsFresh(renderer, device(), scene, settings_);
  addLight(scene, workshop().lights[1]);
  expectAsFresh(renderer, device(), scene, settings_);
  const scene::Camera camera = workshopCamera();
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings_).front());
  EXPECT_TRUE(std::ranges::any_of(imageOf(frame, output::Aov::Color).values, [](float v) { return v > 0 && v < 1; }));
}

// The first mesh with vertex colors enables code that shaders of CPU devices leave out before.
TEST_F(EditCasesTest, TheFirstVertexColors) {
  scene::Scene scene;
  scene.name = scene.source = "plain";
  const scene::Mesh plain = sphereMesh(1);
  scene::Mesh red = plain;
  red.extras.assign(red.positions.size(), {.uv1 = {}, .color = {1, 0, 0, 1}});
  const uint32_t sphere = scene::addMesh(scene, plain);
  const uint32_t material = scene::addMaterial(scene, scene::plainMaterial("white", vec3(1), 0, 0.5f));
  addInstance(scene, sphere, material, standing({0, 0, 1}, 1));
  addLight(scene, workshop().lights[1]);
  const scene::Camera camera = workshopCamera();
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    SCOPED_TRACE(indexOf(raster));
    Settings settings = settings_;
    settings.raster = raster;
    Renderer renderer(device(), scene, nullptr);
    const auto colorsOf = [&](const scene::Mesh& mesh) {
      scene::setMesh(scene, sphere, mesh);
      expectAsFresh(renderer, device(), scene, settings);
      return imageOf(renderer.render({&camera, 1}, settings).front(), output::Aov::Color).values;
    };
    const std::vector<float> white = colorsOf(plain);
    EXPECT_NE(colorsOf(red), white);
    EXPECT_EQ(colorsOf(plain), white);
  }
}

// Without point and spot lights, and with few, no light lists are built.
TEST_F(EditCasesTest, ALocalLightNextToASun) {
  const scene::Light lamp = scene_.lights[1];
  ASSERT_FALSE(shared::lightIsDirectional(lamp.type));
  std::erase_if(scene_.lights, [](const scene::Light& light) { return !shared::lightIsDirectional(light.type); });
  ASSERT_FALSE(scene_.lights.empty());
  Renderer renderer(device(), scene_, nullptr);
  const scene::Camera camera = workshopCamera();
  const auto colorsBy = [&](const char* technique) {
    Settings settings = settings_;
    settings.lighting = &findTechnique(technique);
    expectAsFresh(renderer, device(), scene_, settings);
    return imageOf(renderer.render({&camera, 1}, settings).front(), output::Aov::Color).values;
  };
  const auto expectAgreement = [&] {
    const std::vector<float> expected = colorsBy("fullscreen");
    for (const char* technique : {"clustered", "tiled"}) EXPECT_EQ(colorsBy(technique), expected) << technique;
    return expected;
  };
  const std::vector<float> sunny = expectAgreement();
  const uint32_t added = addLight(scene_, lamp);
  const std::vector<float> lit = expectAgreement();
  EXPECT_NE(lit, sunny);
  std::vector<uint32_t> others;
  for (int i = 0; i < 40; ++i) others.push_back(addLight(scene_, lamp));
  for (const char* technique : {"clustered", "tiled"}) EXPECT_NE(colorsBy(technique), lit) << technique;
  for (const uint32_t light : others) removeLight(scene_, light);
  EXPECT_EQ(expectAgreement(), lit);
  removeLight(scene_, added);
  EXPECT_EQ(expectAgreement(), sunny);
}

TEST_F(EditCasesTest, ALightInTheDark) {
  const scene::Light lamp = scene_.lights[2];
  scene_.lights.clear();
  Renderer renderer(device(), scene_, nullptr);
  expectAsFresh(renderer, device(), scene_, settings_);
  const scene::Camera camera = workshopCamera();
  const auto light = [&] {
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings_).front());
    float sum = 0;
    for (const float value : imageOf(frame, output::Aov::Color).values) sum += value;
    return sum;
  };
  const float dark = light();
  const uint32_t added = addLight(scene_, lamp);
  expectAsFresh(renderer, device(), scene_, settings_);
  EXPECT_GT(light(), dark + 1);
  removeLight(scene_, added);
  expectAsFresh(renderer, device(), scene_, settings_);
  EXPECT_EQ(light(), dark);
}

TEST_F(EditCasesTest, MeshesWithoutTriangles) {
  Renderer renderer(device(), scene_, nullptr);
  setMesh(scene_, 0, scene::Mesh{});
  expectAsFresh(renderer, device(), scene_, settings_);
  setMesh(scene_, 0, squareMesh(true));
  expectAsFresh(renderer, device(), scene_, settings_);
}

// Lists outgrow their capacity on the device, and shrink again.
TEST_F(EditCasesTest, ManyMoreAndFewAgain) {
  Renderer renderer(device(), scene_, nullptr);
  const scene::Light lamp = scene_.lights[1];
  for (uint32_t i = 0; i < 150; ++i) {
    const vec3 at(float(i % 15) / 4 - 2, float(i / 15) / 4, 0.2f);
    addInstance(scene_, i % 3, i % 7, standing(at, 0.15f));
    scene::Light light = lamp;
    light.position = at + vec3(0, -0.5f, 0.5f);
    light.range = 0.5f + float(i % 5);
    addLight(scene_, light);
    if (i < 20) scene::addMaterial(scene_, scene_.materials[i % 7]);
    if (i < 20) scene::addMesh(scene_, scene_.meshes[i % 3]);
    if (i % 30 == 29) expectAsFresh(renderer, device(), scene_, settings_);
  }
  for (uint32_t i = 3; i < scene_.lights.size(); ++i) removeLight(scene_, i);
  for (uint32_t i = 5; i < scene_.instances.size(); ++i) removeInstance(scene_, i);
  expectAsFresh(renderer, device(), scene_, settings_);
}

// --- animated elements ----------------------------------------------------------------------------------------------

class EditMovingTest : public RenderTest, public testing::WithParamInterface<std::string> {
 protected:
  SceneState at(double time) const {
    const scene::Playback playback = scene::choosePlayback(scene_, "", false);
    SceneState moment;
    moment.poses = {scene::poseAt(scene_, playback, time - 0.05), scene::poseAt(scene_, playback, time),
                    scene::poseAt(scene_, playback, time + 0.05)};
    return moment;
  }
  uint32_t moving() const {
    const auto found =
        std::ranges::find_if(scene_.meshes, [](const scene::Mesh& mesh) { return mesh.deformation != nullptr; });
    return static_cast<uint32_t>(found - scene_.meshes.begin());
  }
  scene::Scene scene_ = scene::load(models::modelPath(GetParam()).string());
  Renderer renderer_{device(), scene_, nullptr};

  // At rest, and at several times.
  void expectAllAsFresh() {
    const scene::Camera camera = scene::frameScene(scene_, 1.5f);
    for (const double time : {0.3, -1.0, 0.6}) {
      SCOPED_TRACE(time);
      const SceneState moment = time < 0 ? SceneState{} : at(time);
      const output::FrameOutput frame = std::move(renderer_.render({&camera, 1}, workshopSettings(), moment).front());
      Renderer fresh(device(), scene_, nullptr);
      expectSame(frame, fresh.render({&camera, 1}, workshopSettings(), moment).front());
    }
  }
};

TEST_P(EditMovingTest, PosedScenesAreEdited) {
  expectAllAsFresh();
  const uint64_t pipelines = device().pipelinesMade();
  setTransform(scene_, 0, glm::translate(scene_.instances[0].toWorld, glm::dvec3(0.2f, 0, 0)));
  expectAllAsFresh();
  const uint32_t copy =
      addInstance(scene_, moving(), 0, scene_.instances[0].toWorld * glm::dmat4(standing({1, 0, 0}, 0.8f)));
  expectAllAsFresh();
  scene::Material material = scene_.materials[0];
  material.data.baseColor = {0.9f, 0.1f, 0.1f, 1};
  scene::setMaterial(scene_, 0, material);
  removeInstance(scene_, 0);
  expectAllAsFresh();
  removeInstance(scene_, copy);
  addInstance(scene_, moving(), 0, glm::mat4(1));
  expectAllAsFresh();
  EXPECT_EQ(device().pipelinesMade(), pipelines);
}

TEST_P(EditMovingTest, MeshesThatMoveAreReplaced) {
  expectAllAsFresh();
  const uint64_t pipelines = device().pipelinesMade();
  const uint32_t mesh = moving();
  // Replaced by a mesh that moves as well, but is thinner.
  scene::Mesh thinner = scene_.meshes[mesh];
  auto deformation = std::make_shared<scene::Deformation>(*thinner.deformation);
  for (vec3& p : thinner.positions) p.x *= 0.5f;
  for (vec3& p : deformation->positions) p.x *= 0.5f;
  thinner.deformation = deformation;
  setMesh(scene_, mesh, thinner);
  expectAllAsFresh();
  // Replaced by a static mesh, and back.
  setMesh(scene_, mesh, sphereMesh(0.5f));
  expectAllAsFresh();
  setMesh(scene_, mesh, thinner);
  expectAllAsFresh();
  EXPECT_EQ(device().pipelinesMade(), pipelines);
}

INSTANTIATE_TEST_SUITE_P(Models, EditMovingTest, testing::Values("skinned.glb", "morphed.glb"),
                         [](const auto& info) { return caseName(info); });

// A light on a node that moves, edited between poses.
TEST_F(EditCasesTest, LightsOfPosedScenes) {
  scene::Scene scene = scene::load(models::modelPath("skinned.glb").string());
  Renderer renderer(device(), scene, nullptr);
  const scene::Playback playback = scene::choosePlayback(scene, "", false);
  SceneState moment;
  moment.poses.previous = moment.poses.current = moment.poses.next = scene::poseAt(scene, playback, 0.4);
  expectAsFresh(renderer, device(), scene, settings_, nullptr, moment);
  scene::Light lamp = workshop().lights[1];
  lamp.node = 0;
  const uint32_t light = addLight(scene, lamp);
  expectAsFresh(renderer, device(), scene, settings_, nullptr, moment);
  moment.poses.current = scene::poseAt(scene, playback, 0.8);
  expectAsFresh(renderer, device(), scene, settings_, nullptr, moment);
  lamp.node = -1;
  scene::setLight(scene, light, lamp);
  expectAsFresh(renderer, device(), scene, settings_, nullptr, moment);
  expectAsFresh(renderer, device(), scene, settings_);
}

}  // namespace
}  // namespace latelight::render::test
