// Worlds: every image and all data of a world are, byte for byte, those of the scene edited to the world's state and
// rendered by a separate renderer without worlds.
#include <fmt/core.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "long_tests.h"
#include "models/models.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "worlds/same_frames.h"

namespace latelight::render::test {
namespace {

using glm::dmat4;
using glm::dvec3;
using output::Aov;

constexpr uint32_t kWorlds = 3, kWidth = 40, kHeight = 30;

// All outputs except those about rasterization, which count hidden copies that a world may move apart, and coordinates
// and curvature of objects at rest, which worlds do not change and edits do.
std::vector<Aov> allOutputs() {
  std::vector<Aov> all;
  for (const output::AovInfo& info : output::aovs())
    if (!output::tellsOfRaster(info.aov) && info.aov != Aov::ObjectPosition && info.aov != Aov::Nocs &&
        info.aov != Aov::Curvature)
      all.push_back(info.aov);
  return all;
}

void expectSame(const output::FrameOutput& a, const output::FrameOutput& b) {
  EXPECT_TRUE(latelight::test::haveSameBytes(a.display, b.display)) << "display";
  ASSERT_EQ(a.aovs.size(), b.aovs.size());
  for (size_t i = 0; i < a.aovs.size(); ++i) {
    EXPECT_TRUE(latelight::test::haveSameBytes(a.aovs[i].values, b.aovs[i].values)) << output::info(a.aovs[i].aov).name;
    EXPECT_TRUE(a.aovs[i].ids == b.aovs[i].ids) << output::info(a.aovs[i].aov).name;
  }
}

// A transform near the given one: moved, turned, scaled unevenly, and mirrored in one of four cases.
dmat4 perturbed(const dmat4& toWorld, std::mt19937& random) {
  std::uniform_real_distribution<double> offset(-0.4, 0.4), size(0.7, 1.3);
  const auto three = [&](auto& distribution) {
    return dvec3(distribution(random), distribution(random), distribution(random));
  };
  const dvec3 moved = three(offset), turned = three(offset);
  dvec3 scaled = three(size);
  if (random() % 4 == 0) scaled.x = -scaled.x;
  dmat4 change = glm::translate(dmat4(1), moved);
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 about(0);
    about[axis] = 1;
    change = glm::rotate(change, turned[axis], about);
  }
  return toWorld * glm::scale(change, scaled);
}

// Random states of some of the scene's instances in each world.
WorldStates randomWorlds(const scene::Scene& scene, bool someAbsent) {
  std::mt19937 random(7);
  WorldStates worlds{.count = kWorlds};
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (i % 4 != 1) worlds.instances.push_back(i);  // the others keep the scene's state
  for (uint32_t i = 0; i < kWorlds * worlds.instances.size(); ++i) {
    worlds.transforms.push_back(
        perturbed(scene.instances[worlds.instances[i % worlds.instances.size()]].toWorld, random));
    if (someAbsent) worlds.exists.push_back(random() % 4 != 0);
  }
  return worlds;
}

// Adds random positions, colors and intensities of all lights.
void addRandomLights(const scene::Scene& scene, WorldStates& worlds) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> offset(-0.6f, 0.6f), share(0.2f, 1.5f);
  for (uint32_t i = 0; i < scene.lights.size(); ++i) worlds.lights.push_back(i);
  for (uint32_t i = 0; i < worlds.count * scene.lights.size(); ++i) {
    scene::Light light = scene.lights[i % scene.lights.size()];
    light.node = -1;
    light.position += dvec3(offset(random), offset(random), offset(random));
    light.direction =
        glm::normalize(light.direction + 0.5f * glm::vec3(offset(random), offset(random), offset(random)));
    light.color = {share(random), share(random), share(random)};
    light.intensity *= random() % 4 == 0 ? 0.0f : share(random);  // some emit nothing, so counts differ
    worlds.lightValues.push_back(light);
  }
}

// Adds random materials of the scene, and random factors.
void addRandomMaterials(const scene::Scene& scene, WorldStates& worlds) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> share(0.1f, 1.0f);
  for (size_t i = 0; i < worlds.count * worlds.instances.size(); ++i) {
    worlds.materials.push_back(static_cast<uint32_t>(random() % scene.materials.size()));
    worlds.factors.push_back({.baseColor = {share(random), share(random), share(random), share(random)},
                              .emissive = glm::vec3(0, share(random), 0),
                              .metallic = share(random),
                              .roughness = share(random)});
  }
}

// Gives each listed instance a material of its own, with the id of the material that the world chooses.
void setMaterials(scene::Scene& scene, const WorldStates& worlds, uint32_t world, size_t own) {
  const size_t listed = worlds.instances.size();
  for (size_t i = 0; i < listed; ++i) {
    scene::Material material = scene.materials[worlds.materials[world * listed + i]];
    const MaterialFactors& factors = worlds.factors[world * listed + i];
    const uint32_t id = material.data.id;
    material.data.baseColor = factors.baseColor;
    material.data.emissive = factors.emissive;
    material.data.metallic = factors.metallic;
    material.data.roughness = factors.roughness;
    if (own + i < scene.materials.size())
      scene::setMaterial(scene, static_cast<uint32_t>(own + i), material);
    else
      scene::addMaterial(scene, material);
    scene.materials[own + i].data.id = id;
    scene::setMaterialOf(scene, worlds.instances[i], static_cast<uint32_t>(own + i));
  }
}

// Edits the scene to the state of a world.
void become(scene::Scene& scene, const WorldStates& worlds, uint32_t world) {
  for (size_t i = 0; i < worlds.lights.size(); ++i)
    scene::setLight(scene, worlds.lights[i], worlds.lightValues[world * worlds.lights.size() + i]);
  const size_t listed = worlds.instances.size();
  for (size_t i = 0; i < listed; ++i) {
    scene::setTransform(scene, worlds.instances[i], worlds.transforms[world * listed + i]);
    scene.instances[worlds.instances[i]].hidden = !worlds.exists.empty() && !worlds.exists[world * listed + i];
  }
}

class WorldsTest : public RenderTest {
 protected:
  // Renders two cameras per world, all worlds at once, and compares each with the edited scene.
  static void compare(const std::string& source, Settings settings, const SceneState& moment = {}, bool lights = false,
                      bool materials = false) {
    scene::Scene scene = scene::load(source), edited = scene::load(source);
    const scene::Environment studio = scene::loadEnvironment("studio");
    const bool environment = scene.lights.empty();
    settings.display = true;
    SceneState state = moment;
    state.worlds = randomWorlds(scene, moment.poses.current.empty());
    if (lights) addRandomLights(scene, state.worlds);
    if (materials) addRandomMaterials(scene, state.worlds);
    const size_t materialCount = scene.materials.size();
    if (lights && environment) {
      state.worlds.environmentRotation = {0.3f, -1.2f, 2.5f};
      state.worlds.environmentIntensity = {0.4f, 1.0f, 0.0f};
    }
    std::vector<scene::Camera> cameras;
    for (uint32_t world = 0; world < kWorlds; ++world)
      for (uint32_t i = 0; i < 2; ++i) {
        scene::Camera& camera = cameras.emplace_back(cameraOf(scene, kWidth, kHeight));
        camera.toWorld[3] += glm::dvec4(0.1 * world, 0, 0.2 * i, 0);
        camera.world = world;
      }
    Renderer renderer(device(), scene, environment ? &studio : nullptr);
    const std::vector<output::FrameOutput> together = renderer.submit(cameras, settings, state).take().frames;
    EXPECT_FALSE(together[0].display == together[2].display);  // the worlds must differ
    Renderer alone(device(), edited, environment ? &studio : nullptr);
    for (uint32_t world = 0; world < kWorlds; ++world) {
      become(edited, state.worlds, world);
      if (materials) setMaterials(edited, state.worlds, world, materialCount);
      for (uint32_t i = 0; i < 2; ++i) {
        SCOPED_TRACE(fmt::format("{}, world {}, camera {}", source, world, i));
        scene::Camera camera = cameras[2 * world + i];
        camera.world = 0;
        Settings own = settings;
        if (!state.worlds.environmentRotation.empty()) {
          own.environmentRotation = state.worlds.environmentRotation[world];
          own.environmentIntensity = state.worlds.environmentIntensity[world];
        }
        expectSame(together[2 * world + i], alone.submit({&camera, 1}, own, moment).take().frames.front());
      }
    }
    // Afterward, frames without worlds show the scene's own state.
    const scene::Scene untouched = scene::load(source);
    Renderer other(device(), untouched, environment ? &studio : nullptr);
    const std::span<const scene::Camera> camera(cameras.data(), 1);
    expectSame(renderer.submit(camera, settings, moment).take().frames.front(),
               other.submit(camera, settings, moment).take().frames.front());
  }

  static Settings settingsWith(Raster raster) {
    Settings settings = settingsOf(kWidth, kHeight, allOutputs());
    settings.raster = raster;
    settings.lighting = &findTechnique(raster == Raster::Hardware ? "fullscreen" : "clustered");
    settings.shadows = ShadowFormat::D32;
    return settings;
  }
};

class WorldsWith : public WorldsTest, public testing::WithParamInterface<Raster> {};

std::string caseName(Raster raster) {
  return raster == Raster::Compute ? "Compute" : raster == Raster::Rays ? "Rays" : "Hardware";
}

INSTANTIATE_TEST_SUITE_P(Rasters, WorldsWith, testing::Values(Raster::Compute, Raster::Hardware, Raster::Rays),
                         [](const auto& info) { return caseName(info.param); });

std::string model(const char* name) {
  return models::modelPath(name).string();
}

TEST_P(WorldsWith, AreTheEditedSceneUnderLightsWithShadows) {
  compare(model("punctual.glb"), settingsWith(GetParam()));
}

TEST_P(WorldsWith, AreTheEditedSceneWithMaskedAndBlendedSurfaces) {
  Settings settings = settingsWith(GetParam());
  settings.ambientOcclusion = AmbientOcclusion::Gtao;
  compare(model("blended.glb"), settings);
}

TEST_P(WorldsWith, HaveTheirOwnLights) {
  compare(model("punctual.glb"), settingsWith(GetParam()), {}, true);
}

// The background is part of the environment, which is dark in the third world.
TEST_P(WorldsWith, HaveTheirOwnEnvironment) {
  Settings settings = settingsWith(GetParam());
  settings.background.kind = Background::Environment;
  compare(model("blended.glb"), settings, {}, true);
}

// Opaque, masked and blended instances swap positions.
TEST_P(WorldsWith, HaveTheirOwnMaterials) {
  compare(model("blended.glb"), settingsWith(GetParam()), {}, false, true);
  Settings settings = settingsWith(GetParam());
  settings.dataSurfaces = DataSurfaces::Any;
  settings.lighting = &findTechnique("forward");
  settings.raster = Raster::Hardware;
  if (GetParam() == Raster::Hardware) compare(model("textured.glb"), settings, {}, true, true);
}

// Poses deform the worm and its bounds; worlds move its instance in addition.
TEST_P(WorldsWith, AreTheEditedSceneInAPose) {
  const scene::Scene scene = scene::load(model("skinned.glb"));
  Settings settings = settingsWith(GetParam());
  settings.time = 0.4;
  settings.animation = "bend";
  SceneState moment;
  moment.poses = posesAt(scene, settings);
  compare(model("skinned.glb"), settings, moment);
}

// Every technique that draws the scene itself, and four samples per pixel.
TEST_F(WorldsTest, TechniquesThatDrawAreThoseOfTheEditedScene) {
  for (const auto& [lighting, transparency, samples] :
       {std::tuple{"volumes", TransparencyMethod::Sorted, 1},
        std::tuple{"forward-multipass", TransparencyMethod::Weighted, 1},
        std::tuple{"forward", TransparencyMethod::Exact, 4}}) {
    SCOPED_TRACE(lighting);
    Settings settings = settingsWith(Raster::Hardware);
    settings.aovs = {Aov::Color, Aov::Depth};
    settings.lighting = &findTechnique(lighting);
    settings.transparency = transparency;
    settings.aa.samples = static_cast<uint32_t>(samples);
    settings.sun = SunLight{.azimuth = 0.5f, .elevation = 0.8f};
    compare(model("punctual.glb"), settings, {}, true);
    compare(model("blended.glb"), settings);
  }
}

// A ball moves between a lamp and a floor, which determines the bounds of the scene, so the lamp's shadow maps are at
// the same position in the atlas with and without worlds.
TEST_P(WorldsWith, DoNotChangeShadowsOfLaterFrames) {
  scene::SceneBuilder builder("ball");
  builder.scene.meshes = {sphereMesh(0.5f), squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", glm::vec3(0.8f), 0, 1)};
  builder.addInstance("ball", builder.kRoot, 0, 0);
  const glm::mat4 flat =
      glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0, -1, 0)), -1.5707964f, glm::vec3(1, 0, 0));
  builder.addInstance("floor", builder.kRoot, 1, 0, glm::scale(flat, glm::vec3(6)));
  builder.addInstance("ceiling", builder.kRoot, 1, 0,
                      glm::scale(glm::translate(flat, glm::vec3(0, 0, 4)), glm::vec3(6)));
  scene::Light lamp;
  lamp.name = "lamp";
  lamp.position = {0, 0, 1.5};
  lamp.intensity = 20;
  builder.scene.lights = {lamp};
  Settings settings = settingsWith(GetParam());
  settings.aovs = {Aov::Color};
  settings.shadowAtlas = 256;
  scene::Camera camera = frontPerspective(1.2f, 5);
  camera.toWorld = glm::translate(dmat4(1), dvec3(0, 0, 0.8)) * camera.toWorld;
  Renderer renderer(device(), builder.scene, nullptr);
  SceneState state;
  state.worlds = {.count = 1, .instances = {0}};
  state.worlds.transforms = {glm::translate(builder.scene.instances[0].toWorld, dvec3(1.2, 0.3, 0))};
  const output::FrameOutput moved = renderer.submit({&camera, 1}, settings, state).take().frames.front();
  const output::FrameOutput after = renderer.submit({&camera, 1}, settings).take().frames.front();
  EXPECT_NE(imageOf(moved, Aov::Color).values, imageOf(after, Aov::Color).values);
  Renderer other(device(), builder.scene, nullptr);
  expectSame(after, other.submit({&camera, 1}, settings).take().frames.front());
}

// --- rays ------------------------------------------------------------------------------------------------------------

// Rays of a view hit the instances of its own world.
TEST_P(WorldsWith, CastShadowsByRays) {
  Settings settings = settingsWith(GetParam());
  settings.shadows = ShadowFormat::Rays;
  settings.shadowFilter = ShadowFilter::Pcss;
  settings.samples = 3;
  compare(model("punctual.glb"), settings);
  compare(model("punctual.glb"), settings, {}, true);
  settings.sun = SunLight{.azimuth = 0.5f, .elevation = 0.8f};
  compare(model("blended.glb"), settings, {}, false, true);
}

// Materials differ, so masked, blended and emissive surfaces are others in each world, and some are absent.
TEST_P(WorldsWith, ReceiveLightAlongPaths) {
  if (GetParam() != Raster::Compute) {  // the rays are the same
    LATELIGHT_SKIP_UNLESS_ALL();
  }
  Settings settings = settingsWith(GetParam());
  settings.indirect = Indirect::Path;
  settings.samples = 2;
  compare(model("blended.glb"), settings);
  settings.indirectFilter = IndirectFilter::Spatial;
  compare(model("punctual.glb"), settings, {}, true, true);
}

TEST_P(WorldsWith, AreTracedByTheReference) {
  if (GetParam() != Raster::Compute) {  // the rays are the same
    LATELIGHT_SKIP_UNLESS_ALL();
  }
  Settings settings = settingsWith(GetParam());
  settings.lighting = &findTechnique("reference");
  settings.samples = 2;
  settings.background.kind = Background::Environment;
  compare(model("blended.glb"), settings, {}, true, true);
}

// The worm deforms in the scene's pose, and worlds move it.
TEST_P(WorldsWith, CastShadowsByRaysInAPose) {
  const scene::Scene scene = scene::load(model("skinned.glb"));
  Settings settings = settingsWith(GetParam());
  settings.time = 0.4;
  settings.animation = "bend";
  settings.shadows = ShadowFormat::Rays;
  settings.sun = SunLight{.azimuth = 0.5f, .elevation = 0.8f};
  settings.indirect = Indirect::OneBounce;
  settings.samples = 2;
  SceneState moment;
  moment.poses = posesAt(scene, settings);
  compare(model("skinned.glb"), settings, moment);
}

// --- motion ----------------------------------------------------------------------------------------------------------

// A square that fills the image and moved by a different distance in each world: an orthographic camera shows kWidth /
// 2 pixels per meter, so the motion follows from the distance.
TEST_P(WorldsWith, HaveTheirOwnMotion) {
  scene::SceneBuilder builder("square");
  builder.scene.meshes = {squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", glm::vec3(0.5f), 0, 1)};
  builder.addInstance("square", builder.kRoot, 0, 0, glm::scale(glm::mat4(1), glm::vec3(3)));
  const dmat4 here = builder.scene.instances[0].toWorld;
  SceneState state;
  state.worlds = {.count = 2, .instances = {0}, .transforms = {here, here}};
  const auto moved = [&](double right) { return glm::translate(dmat4(1), dvec3(right, 0, 0)) * here; };
  state.worlds.previous = {moved(-0.25), moved(0.5)};
  state.worlds.next = {moved(0.125), here};
  std::vector<scene::Camera> cameras(2, frontCamera());
  cameras[1].world = 1;
  Settings settings = settingsOf(32, 32, {Aov::Motion});
  settings.raster = GetParam();
  Renderer renderer(device(), builder.scene, nullptr);
  const std::vector<output::FrameOutput> frames = renderer.submit(cameras, settings, state).take().frames;
  const float expected[2][4] = {{-4, 0, 2, 0}, {8, 0, 0, 0}};  // to the previous and the next position, in pixels
  for (size_t world = 0; world < 2; ++world)
    for (size_t i = 0; i < 4 * 32 * 32; ++i)
      ASSERT_NEAR(imageOf(frames[world], Aov::Motion).values[i], expected[world][i % 4], 1e-4) << world << ", " << i;
}

// --- limits ----------------------------------------------------------------------------------------------------------

// A world without instances is empty and does not affect the other worlds.
TEST_P(WorldsWith, MayBeEmpty) {
  const scene::Scene scene = scene::load("builtin:boxes");
  SceneState state;
  state.worlds = {.count = 3, .empty = {0, 1, 0}};
  std::vector<scene::Camera> cameras(3, scene.cameras.front());
  for (uint32_t world = 0; world < 3; ++world) cameras[world].world = world;
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Id});
  settings.raster = GetParam();
  Renderer renderer(device(), scene, nullptr);
  const std::vector<output::FrameOutput> frames = renderer.submit(cameras, settings, state).take().frames;
  const std::vector<uint32_t> alone = imageOf(renderOne(device(), scene, scene.cameras.front(), settings), Aov::Id).ids;
  EXPECT_EQ(imageOf(frames[1], Aov::Id).ids, std::vector<uint32_t>(kWidth * kHeight, 0));
  for (const size_t world : {0, 2}) EXPECT_EQ(imageOf(frames[world], Aov::Id).ids, alone);
}

// Calls that differ only in values submit recorded commands again, and these are those of the call's values.
TEST_F(WorldsTest, SteadyCallsAreReplayed) {
  scene::Scene scene = scene::load("builtin:boxes"), edited = scene::load("builtin:boxes");
  std::vector<scene::Camera> cameras(2, scene.cameras.front());
  cameras[1].world = 1;
  Settings settings = settingsWith(Raster::Compute);
  settings.shadows = ShadowFormat::None;
  Renderer renderer(device(), scene, nullptr), alone(device(), edited, nullptr);
  uint32_t replays = 0;
  for (uint32_t call = 0; call < 5; ++call) {
    SceneState state;
    state.worlds = {.count = 2, .instances = {0}};
    for (uint32_t world = 0; world < 2; ++world)
      state.worlds.transforms.push_back(glm::translate(scene.instances[0].toWorld, dvec3(0.05 * call, 0.1 * world, 0)));
    RenderResult result = renderer.submit(cameras, settings, state).take();
    replays += result.statistics.replays;
    for (uint32_t world = 0; world < 2; ++world) {
      become(edited, state.worlds, world);
      expectSame(result.frames[world], alone.render({&scene.cameras.front(), 1}, settings).front());
    }
  }
  EXPECT_EQ(replays, 3u) << "the first call renders, the second one is recorded";
}

// More worlds than are rendered at once, so they are rendered in groups.
TEST_F(WorldsTest, AreRenderedInGroups) {
  constexpr uint32_t kMany = 300;
  scene::Scene scene = scene::load("builtin:boxes"), edited = scene::load("builtin:boxes");
  SceneState state;
  state.worlds = {.count = kMany, .instances = {0}};
  std::vector<scene::Camera> cameras(kMany, scene.cameras.front());
  for (uint32_t world = 0; world < kMany; ++world) {
    cameras[world].world = world;
    state.worlds.transforms.push_back(glm::translate(scene.instances[0].toWorld, dvec3(0.01 * world, 0, 0)));
  }
  const Settings settings{.width = 24, .height = 16, .aovs = {Aov::Depth}};
  Renderer renderer(device(), scene, nullptr), alone(device(), edited, nullptr);
  const std::vector<output::FrameOutput> all = renderer.submit(cameras, settings, state).take().frames;
  ASSERT_EQ(all.size(), kMany);
  for (const uint32_t world : {0u, 255u, 256u, 299u}) {
    become(edited, state.worlds, world);
    expectSame(all[world], alone.render({&scene.cameras.front(), 1}, settings).front());
  }
  EXPECT_FALSE(all[0].display == all[299].display);
}

}  // namespace
}  // namespace latelight::render::test
