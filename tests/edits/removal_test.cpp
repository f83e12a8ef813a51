// Removing meshes, materials and textures: which element replaces a removed one, and the memory that is freed.
#include <gmock/gmock.h>

#include <functional>

#include "base/error.h"
#include "edits/host_memory.h"
#include "edits/workshop.h"
#include "error_of.h"
#include "scene/animation.h"
#include "scene/edit.h"
#include "test_device.h"
#include "vk/memory.h"
#include "without_validation.h"

namespace latelight::render::test {
namespace {

using testing::HasSubstr;

// --- elements that the scene had at first ---------------------------------------------------------------------------

class RemovalTest : public RenderTest {
 protected:
  scene::Scene scene_ = workshop();
  const Settings settings_ = workshopSettings();
};

TEST_F(RemovalTest, RemovedInstancesWhoseMeshIsGoneAreNotRestored) {
  const uint32_t instance = 1, mesh = scene_.instances[1].mesh;
  for (uint32_t i = 0; i < scene_.instances.size(); ++i)
    if (scene_.instances[i].mesh == mesh) removeInstance(scene_, i);
  restoreInstance(scene_, instance);
  removeInstance(scene_, instance);
  Renderer renderer(device(), scene_, nullptr);
  removeMesh(scene_, mesh);
  addMesh(scene_, squareMesh());
  EXPECT_THAT(errorOf([&] { restoreInstance(scene_, instance); }), HasSubstr("is not one of the scene's own"));
  expectAsFresh(renderer, device(), scene_, settings_);
}

// An animation that targets a removed element does not animate the element that takes its slot.
TEST_F(RemovalTest, AnimationsLeaveWhatTakesThePlaceAlone) {
  scene_.rig.nodes.resize(scene_.nodes.size());
  for (uint32_t i = 0; i < scene_.nodes.size(); ++i) scene_.rig.order.push_back(i), scene_.rig.sceneNodes.push_back(i);
  const uint32_t material = addMaterial(scene_, scene_.materials[0]), light = addLight(scene_, scene_.lights[1]);
  scene::Animation& animation = scene_.rig.animations.emplace_back();
  animation.duration = 1;
  const auto add = [&](scene::AnimatedElements elements, uint32_t index, const char* pointer) {
    const scene::AnimatedValue value = scene::findAnimatedValue(elements, pointer).value();
    scene::ValueTrack track;
    track.elements = elements;
    track.indices = {index};
    track.property = value.property;
    track.slot = value.slot;
    track.width = value.width;
    track.times = {0, 1};
    track.values.assign(2 * value.width, 0.25f);
    animation.values.push_back(track);
  };
  add(scene::AnimatedElements::Materials, material, "pbrMetallicRoughness/roughnessFactor");
  add(scene::AnimatedElements::Lights, light, "intensity");
  const auto pose = [&] { return scene::poseAt(scene_, scene::choosePlayback(scene_, "", false), 0.5); };
  EXPECT_EQ(scene::posedMaterials(scene_, pose()).at(material).roughness, 0.25f);
  EXPECT_EQ(scene::posedLights(scene_, pose())[light].intensity, 0.25f);
  removeMaterial(scene_, material);
  removeLight(scene_, light);
  ASSERT_EQ(addMaterial(scene_, scene_.materials[0]), material);
  ASSERT_EQ(addLight(scene_, scene_.lights[1]), light);
  EXPECT_FALSE(scene::posedMaterials(scene_, pose()).contains(material));
  EXPECT_EQ(scene::posedLights(scene_, pose())[light].intensity, scene_.lights[1].intensity);
}

// If a frame fails after it has accepted the scene's changes, the next frame applies them, even if the scene changes
// again.
TEST_F(RemovalTest, WhatAFailedFrameWasToUploadMayBeReplaced) {
  vk::Device own({.selector = latelight::test::testDevice(), .validation = true, .graphics = false});
  Renderer renderer(own, scene_, nullptr);
  const scene::Camera camera = workshopCamera();
  Settings drawn = settings_, computed = settings_;
  drawn.raster = Raster::Hardware;
  computed.raster = Raster::Compute;
  renderer.render({&camera, 1}, computed);
  for (const uint32_t side : {8u, 4u}) {
    setTexture(scene_, 0,
               textureOf(side, side, true, std::vector<glm::u8vec4>(side * side, glm::u8vec4(200, 10, 10, 255))));
    setMesh(scene_, 1, side == 8 ? sphereMesh(0.4f) : squareMesh());
    EXPECT_THROW(renderer.render({&camera, 1}, drawn), Error) << "the device has no graphics pipeline";
  }
  expectAsFresh(renderer, own, scene_, computed);
  for (const std::string& message : own.validationMessages()) ADD_FAILURE() << message;
}

// --- memory ---------------------------------------------------------------------------------------------------------

// A thousand rounds of a texture, a material, a mesh and an instance. 64 x 64 texels and their mip levels are 22 kB, so
// that memory that is not freed is measurable on the device and on the host.
TEST_F(RemovalTest, AThousandRoundsTakeNoMemory) {
  constexpr int kRounds = 1000;
  constexpr uint32_t kSide = 64;
  const latelight::test::WithoutValidation withoutValidation;
  vk::Device own({.selector = latelight::test::testDevice()});
  Renderer renderer(own, scene_, nullptr);
  const scene::Camera camera = workshopCamera();
  Settings settings = settings_;
  settings.aovs = {output::Aov::Id};
  settings.display = false;
  std::vector<uint64_t> onDevice;
  std::vector<size_t> onHost;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<glm::u8vec4> texels(kSide * kSide, glm::u8vec4(round & 255, 100, 100, 255));
    const uint32_t texture = addTexture(scene_, textureOf(kSide, kSide, true, texels));
    scene::Material paint = scene_.materials[0];
    test::setTexture(paint, shared::kTextureBaseColor, static_cast<int>(texture));
    const uint32_t material = addMaterial(scene_, paint), mesh = addMesh(scene_, sphereMesh(0.2f));
    const uint32_t instance = addInstance(scene_, mesh, material, glm::mat4(1));
    if (round % 8 == 0) renderer.render({&camera, 1}, settings);
    scene::setTexture(scene_, texture, textureOf(kSide, kSide, true, texels));
    if (round % 8 == 4) renderer.render({&camera, 1}, settings);
    removeInstance(scene_, instance);
    removeMesh(scene_, mesh);
    removeMaterial(scene_, material);
    removeTexture(scene_, texture);
    if (round % 100 != 99) continue;
    // After these frames, no resource of earlier ones is cached.
    onHost.push_back(leastHostBytes([&] { renderer.render({&camera, 1}, settings); }));
    onDevice.push_back(own.memory().statistics().usedBytes);
  }
  EXPECT_LE(onDevice.back(), onDevice[1]);
  EXPECT_LE(steadyGrowth(std::span(onHost).subspan(1)), 100 * 100) << "100 bytes per round";
  EXPECT_EQ(scene_.textures.size(), 4u);
  EXPECT_EQ(scene_.materials.size(), workshop().materials.size() + 1);
}

}  // namespace
}  // namespace latelight::render::test
