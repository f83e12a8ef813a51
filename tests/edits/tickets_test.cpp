// Pictures that are in flight while the scene changes: they equal those without concurrent edits.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <deque>

#include "base/error.h"
#include "edits/workshop.h"
#include "models/models.h"
#include "scene/animation.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "test_device.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kTicketFrames = 10;

// The scene of a frame: transforms, materials, lights and instances differ in each.
void editFor(scene::Scene& scene, uint32_t frame) {
  Dice dice(frame + 1);
  const uint32_t moved = dice.below(static_cast<uint32_t>(scene.instances.size()));
  glm::mat4 place = scene.instances[moved].toWorld;
  place[3] += glm::vec4(dice.between(-0.3f, 0.3f), dice.between(-0.3f, 0.3f), 0.05f, 0);
  setTransform(scene, moved, place);
  scene::Light light = scene.lights[frame % scene.lights.size()];
  light.intensity *= dice.between(0.5f, 2);
  setLight(scene, frame % static_cast<uint32_t>(scene.lights.size()), light);
  scene::Material material = scene.materials[frame % scene.materials.size()];
  material.data.roughness = dice.unit();
  setMaterial(scene, frame % static_cast<uint32_t>(scene.materials.size()), material);
  place[3].z += 0.4f;
  addInstance(scene, scene.instances[moved].mesh, scene.instances[moved].material, place);
}

// A scene whose frames differ by edits or poses, and the settings with which they are rendered.
struct Story {
  scene::Scene scene = workshop();
  scene::Camera camera = workshopCamera();
  Settings settings = workshopSettings();
  scene::Environment sky = constantEnvironment();

  SceneState at(uint32_t frame) {
    SceneState moment{.continues = frame > 0};
    if (scene.rig.animations.empty()) {
      if (frame > 0) editFor(scene, frame);
      return moment;
    }
    const scene::Playback playback = scene::choosePlayback(scene, "", true);
    const double time = 0.11 * frame;
    moment.poses = {scene::poseAt(scene, playback, time - 0.1), scene::poseAt(scene, playback, time),
                    scene::poseAt(scene, playback, time + 0.1)};
    return moment;
  }
};

class TicketsTest : public RenderTest {
 protected:
  // Compares frames that are rendered one by one with frames that are submitted before the previous ones are read back.
  static void compare(const std::function<Story()>& begin) {
    std::vector<output::FrameOutput> expected;
    {
      Story story = begin();
      Renderer renderer(device(), story.scene, &story.sky);
      for (uint32_t frame = 0; frame < kTicketFrames; ++frame) {
        const SceneState moment = story.at(frame);
        expected.push_back(std::move(renderer.render({&story.camera, 1}, story.settings, moment).front()));
      }
    }
    constexpr std::pair<size_t, Results> kWays[] = {{1, Results::ToHost}, {3, Results::OnDevice}, {6, Results::ToHost}};
    for (const auto& [ahead, results] : kWays) {
      Story story = begin();
      Renderer renderer(device(), story.scene, &story.sky);
      std::deque<Ticket> tickets;
      uint32_t taken = 0;
      const auto take = [&, ahead = ahead] {
        SCOPED_TRACE(fmt::format("frame {}, up to {} ahead", taken, ahead));
        expectSame(tickets.front().take().frames.front(), expected[taken++]);
        tickets.pop_front();
      };
      for (uint32_t frame = 0; frame < kTicketFrames; ++frame) {
        const SceneState moment = story.at(frame);
        tickets.push_back(renderer.submit({&story.camera, 1}, story.settings, moment, results));
        if (tickets.size() > ahead) take();
      }
      while (!tickets.empty()) take();
    }
    EXPECT_FALSE(expected[0].display == expected[1].display) << "the frames do differ";
  }
};

TEST_F(TicketsTest, EditsMayFollowBeforePicturesAreTaken) {
  compare([] { return Story(); });
}

TEST_F(TicketsTest, SeveralSamplesAPixel) {
  for (const AntiAliasing aa : {AntiAliasing{.superSampling = 2}, {.samples = 4}, {.temporal = true}}) {
    SCOPED_TRACE(fmt::format("{} samples, super-sampled by {}", aa.samples, aa.superSampling));
    compare([&] {
      Story story;
      story.settings.aa = aa;
      return story;
    });
  }
}

TEST_F(TicketsTest, Strips) {
  compare([] {
    Story story;
    story.settings.height = 300;
    story.settings.stripPixels = 48 * 16;
    EXPECT_GT(stripsOf(story.settings).size(), 3u);
    return story;
  });
}

TEST_F(TicketsTest, PosesOfSkinsAndMorphTargets) {
  for (const char* model : {"skinned.glb", "morphed.glb"}) {
    SCOPED_TRACE(model);
    compare([&] {
      Story story;
      story.scene = scene::load(models::modelPath(model).string());
      story.camera = cameraOf(story.scene, story.settings.width, story.settings.height);
      return story;
    });
  }
}

// Overflow is detected only after the device has finished. The frame is then rendered again with the scene as it was.
TEST_F(TicketsTest, OverflowIsOfTheSceneAsItWasSubmitted) {
  Story story;
  const auto blended = std::ranges::find_if(story.scene.instances, [&](const scene::Instance& instance) {
    return (story.scene.materials[instance.material].data.flags & shared::kMaterialBlended) != 0;
  });
  ASSERT_NE(blended, story.scene.instances.end());
  const scene::Instance card = *blended;
  for (int i = 0; i < 40; ++i) addInstance(story.scene, card.mesh, card.material, card.toWorld);
  const output::FrameOutput expected = renderOne(device(), story.scene, story.camera, story.settings, &story.sky);
  Renderer renderer(device(), story.scene, &story.sky);
  Ticket ticket = renderer.submit({&story.camera, 1}, story.settings);
  for (uint32_t i = 0; i < 40; ++i)
    removeInstance(story.scene, static_cast<uint32_t>(story.scene.instances.size()) - 1 - i);
  Ticket after = renderer.submit({&story.camera, 1}, story.settings);
  const output::FrameOutput later = after.take().frames.front();
  expectSame(ticket.take().frames.front(), expected);
  expectSame(later, renderOne(device(), story.scene, story.camera, story.settings, &story.sky));
  EXPECT_FALSE(later.display == expected.display);
}

TEST_F(TicketsTest, ManyViewsAtOnce) {
  Story story;
  std::vector<scene::Camera> cameras(7, story.camera);
  for (size_t i = 0; i < cameras.size(); ++i) cameras[i].toWorld[3].x += 0.1f * static_cast<float>(i);
  Renderer renderer(device(), story.scene, &story.sky);
  Ticket first = renderer.submit(cameras, story.settings);
  const std::vector<output::FrameOutput> second = renderer.render(std::span(cameras).first(3), story.settings);
  const std::vector<output::FrameOutput> all = first.take().frames;
  ASSERT_EQ(all.size(), cameras.size());
  for (size_t i = 0; i < second.size(); ++i) expectSame(second[i], all[i]);
  for (size_t i = 0; i < all.size(); ++i)
    expectSame(all[i], renderOne(device(), story.scene, cameras[i], story.settings, &story.sky));
}

TEST_F(TicketsTest, DroppedOnesLeaveNothing) {
  Story story;
  const output::FrameOutput expected = renderOne(device(), story.scene, story.camera, story.settings, &story.sky);
  vk::Device own({.selector = latelight::test::testDevice()});
  Renderer renderer(own, story.scene, &story.sky);
  const auto bytes = [&] {
    for (int i = 0; i < 6; ++i) expectSame(renderer.render({&story.camera, 1}, story.settings).front(), expected);
    return own.memory().statistics().usedBytes;
  };
  const uint64_t before = bytes();
  for (int i = 0; i < 20; ++i) renderer.submit({&story.camera, 1}, story.settings);
  EXPECT_LE(bytes(), before);
}

TEST_F(TicketsTest, WhatGoesWrongIsThrownWhereItIsTaken) {
  Story story;
  Renderer renderer(device(), story.scene, &story.sky);
  Settings wrong = story.settings;
  wrong.background.kind = Background::Color;
  wrong.width = 0;
  EXPECT_THROW(renderer.submit({&story.camera, 1}, wrong), Error);
  expectSame(renderer.render({&story.camera, 1}, story.settings).front(),
             renderOne(device(), story.scene, story.camera, story.settings, &story.sky));
}

}  // namespace
}  // namespace latelight::render::test
