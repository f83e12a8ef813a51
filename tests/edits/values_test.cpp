// Animated properties other than transforms: properties of materials and lights, and visibility.
#include <algorithm>

#include "edits/workshop.h"
#include "scene/animation.h"
#include "scene/edit.h"

namespace latelight::render::test {
namespace {

constexpr float kFrom = 0.25f, kTo = 0.75f;

scene::ValueTrack lineOf(scene::AnimatedElements elements, uint32_t index, const char* pointer) {
  const scene::AnimatedValue value = scene::findAnimatedValue(elements, pointer).value();
  scene::ValueTrack track;
  track.elements = elements;
  track.indices = {index};
  track.property = value.property;
  track.slot = value.slot;
  track.width = value.width;
  track.times = {0, 1};
  for (const float end : {kFrom, kTo}) track.values.insert(track.values.end(), value.width, end);
  return track;
}

constexpr uint32_t kHidden = 2, kLight = 0, kHiddenLight = 1;

// The workshop with nodes that no animation moves. One light is on the node of an instance.
scene::Scene standing() {
  scene::Scene scene = workshop();
  scene.rig.nodes.resize(scene.nodes.size());
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) scene.rig.order.push_back(i), scene.rig.sceneNodes.push_back(i);
  for (scene::Instance& instance : scene.instances) instance.placed = true;
  scene.lights[kHiddenLight].node = int(scene.instances[kHidden].node);
  return scene;
}

// Animates materials and a light, and makes an instance and a light visible after half a second.
class ValuesTest : public RenderTest {
 protected:
  ValuesTest() {
    using enum scene::AnimatedElements;
    scene::Animation& animation = scene_.rig.animations.emplace_back();
    animation.duration = 1;
    animation.values.push_back(lineOf(Materials, 0, "pbrMetallicRoughness/baseColorFactor"));
    animation.values.push_back(lineOf(Materials, kTextured, "pbrMetallicRoughness/roughnessFactor"));
    animation.values.push_back(
        lineOf(Materials, kTextured, "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset"));
    animation.values.push_back(lineOf(Lights, kLight, "color"));
    scene::Track shown;
    shown.node = scene_.instances[kHidden].node;
    shown.property = scene::AnimatedProperty::Visible;
    shown.interpolation = scene::Interpolation::Step;
    shown.width = 1;
    shown.times = {0, 0.5f};
    shown.values = {0, 1};
    animation.tracks.push_back(shown);
  }

  static SceneState at(const scene::Scene& scene, double seconds) {
    // The edited scene has the same rig without animations.
    const scene::Pose pose = scene.rig.isAnimated()
                                 ? scene::poseAt(scene, scene::choosePlayback(scene, "", false), seconds)
                                 : scene::restPose(scene);
    return {.poses = {pose, pose, pose}};
  }

  // Sets the same values with edits.
  scene::Scene edited(double seconds) const {
    scene::Scene scene = standing();
    const float value = kFrom + (kTo - kFrom) * float(seconds);
    scene::Material first = scene.materials[0];
    first.data.baseColor = glm::vec4(value);
    scene::setMaterial(scene, 0, first);
    scene::Material textured = scene.materials[kTextured];
    textured.data.roughness = value;
    scene::setRows(textured.data.transforms[0], {.offset = glm::vec2(value)});  // rig.materials has no other parts
    scene::setMaterial(scene, kTextured, textured);
    scene::Light light = scene.lights[kLight];
    light.color = glm::vec3(value);
    setLight(scene, kLight, light);
    if (seconds < 0.5) {
      removeInstance(scene, kHidden);
      removeLight(scene, kHiddenLight);
    }
    return scene;
  }

  scene::Scene scene_ = standing();
  const uint32_t kTextured =
      uint32_t(std::ranges::find_if(scene_.materials,
                                    [](const scene::Material& material) { return (material.data.textures & 1) != 0; }) -
               scene_.materials.begin());
  Settings settings_ = workshopSettings();
  const scene::Camera camera_ = workshopCamera();
};

// Frame by frame, forward and backward, with both rasters.
TEST_F(ValuesTest, AreThoseOfEditsAtThatTime) {
  ASSERT_LT(kTextured, scene_.materials.size());
  settings_.aovs.clear();  // an edited scene has different ids
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    settings_.raster = raster;
    Renderer renderer(device(), scene_, nullptr);
    std::vector<output::FrameOutput> frames;
    for (const double seconds : {0.0, 0.25, 0.5, 1.0, 0.25}) {
      SCOPED_TRACE(seconds);
      frames.push_back(std::move(renderer.render({&camera_, 1}, settings_, at(scene_, seconds)).front()));
      const scene::Scene expected = edited(seconds);
      Renderer fresh(device(), expected, nullptr);
      expectSame(frames.back(), fresh.render({&camera_, 1}, settings_, at(expected, seconds)).front());
    }
    EXPECT_FALSE(frames[0].display == frames[1].display) << "the frames do differ";
    EXPECT_TRUE(frames[1].display == frames[4].display);
  }
}

TEST_F(ValuesTest, AtRestTheyAreThoseOfTheScene) {
  Renderer renderer(device(), scene_, nullptr);
  expectAsFresh(renderer, device(), scene_, settings_);
  expectAsFresh(renderer, device(), scene_, settings_, nullptr, at(scene_, 0.25));
  expectAsFresh(renderer, device(), scene_, settings_);
}

// Edits are applied in addition to the animation.
TEST_F(ValuesTest, FollowEdits) {
  Renderer renderer(device(), scene_, nullptr);
  expectAsFresh(renderer, device(), scene_, settings_, nullptr, at(scene_, 0.25));
  scene::Material material = scene_.materials[0];
  material.data.metallic = 0.9f;
  setMaterial(scene_, 0, material);
  expectAsFresh(renderer, device(), scene_, settings_, nullptr, at(scene_, 0.25));
  scene::Light light = scene_.lights[kLight];
  light.intensity *= 2;
  setLight(scene_, kLight, light);
  expectAsFresh(renderer, device(), scene_, settings_, nullptr, at(scene_, 0.25));
  expectAsFresh(renderer, device(), scene_, settings_);
}

}  // namespace
}  // namespace latelight::render::test
