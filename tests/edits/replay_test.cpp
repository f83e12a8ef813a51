// Requests that repeat: cameras, transforms and lights change, and everything else stays, so the renderer submits the
// commands of an earlier request again. Pictures equal those of a renderer without a past, to the byte.
#include <fmt/core.h>

#include <deque>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>

#include "edits/workshop.h"
#include "scene/edit.h"
#include "test_device.h"
#include "vk/memory.h"

namespace latelight::render::test {
namespace {

Settings replaySettings() {
  Settings settings = workshopSettings();
  settings.raster = Raster::Compute;
  settings.shadows = ShadowFormat::None;
  settings.width = 40;
  settings.height = 24;
  return settings;
}

// Several cameras, which differ from call to call.
std::vector<scene::Camera> camerasOf(uint32_t call, size_t count = 2) {
  std::vector<scene::Camera> cameras(count, workshopCamera());
  for (size_t i = 0; i < count; ++i)
    cameras[i].toWorld[3] += glm::dvec4(0.07 * call, 0.2 * static_cast<double>(i), 0.03 * call, 0);
  return cameras;
}

void moveInstance(scene::Scene& scene, uint32_t call) {
  const uint32_t moved = call % static_cast<uint32_t>(scene.instances.size());
  setTransform(scene, moved, glm::translate(scene.instances[moved].toWorld, glm::dvec3(0.05, 0.1, 0)));
}

class ReplayTest : public RenderTest {
 protected:
  static void expectFresh(const RenderResult& result, const scene::Scene& scene,
                          const std::vector<scene::Camera>& cameras, const Settings& settings) {
    ASSERT_EQ(result.frames.size(), cameras.size());
    Renderer fresh(device(), scene, &sky());
    const std::vector<output::FrameOutput> expected = fresh.render(cameras, settings);
    for (size_t i = 0; i < cameras.size(); ++i) expectSame(result.frames[i], expected[i]);
  }
  static const scene::Environment& sky() {
    static const scene::Environment sky = constantEnvironment();
    return sky;
  }
};

TEST_F(ReplayTest, CamerasMove) {
  const scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  Renderer renderer(device(), scene, &sky());
  for (uint32_t call = 0; call < 6; ++call) {
    SCOPED_TRACE(call);
    const std::vector<scene::Camera> cameras = camerasOf(call);
    const RenderResult result = renderer.submit(cameras, settings).take();
    EXPECT_EQ(result.statistics.replays, call < 2 ? 0u : 1u) << "the second one is recorded";
    EXPECT_FALSE(result.statistics.passTimes.empty());
    expectFresh(result, scene, cameras, settings);
  }
}

// Calls of an agent's loop, between which it evaluates.
TEST_F(ReplayTest, RareCallsAreReplayed) {
  const scene::Scene scene = workshop();
  const Settings often = replaySettings();
  Settings rarely = often;
  rarely.width += 8;
  Renderer renderer(device(), scene, &sky());
  for (uint32_t call = 0; call < 40; ++call) {
    SCOPED_TRACE(call);
    const bool rare = call % 13 == 0;
    const RenderResult result = renderer.submit(camerasOf(call), rare ? rarely : often).take();
    EXPECT_EQ(result.statistics.replays, call > 13 ? 1u : result.statistics.replays);
    if (rare) expectFresh(result, scene, camerasOf(call), rarely);
  }
}

// Each call changes something: what is data is replayed, and nothing that is replayed is out of date.
TEST_F(ReplayTest, EditsAndOtherRequestsComeBetween) {
  scene::Scene scene = workshop();
  Renderer renderer(device(), scene, &sky());
  uint32_t replays = 0;
  for (uint32_t call = 0; call < 24; ++call) {
    SCOPED_TRACE(call);
    Settings settings = replaySettings();
    size_t views = 2;
    if (call >= 3 && call < 9) moveInstance(scene, call);
    if (call == 9) settings.width += 8;
    if (call == 11) {
      scene::Material material = scene.materials[1];
      material.data.roughness = 0.9f;
      setMaterial(scene, 1, material);
    }
    if (call >= 13 && call < 16) {
      scene::Light light = scene.lights[1];
      light.intensity += static_cast<float>(call);
      setLight(scene, 1, light);
    }
    if (call == 17) views = 3;
    if (call == 19) addInstance(scene, 0, 3, glm::translate(glm::mat4(1), glm::vec3(0.3f, 0.2f, 1)));
    if (call == 21) settings.exposure = 1;
    const std::vector<scene::Camera> cameras = camerasOf(call, views);
    const RenderResult result = renderer.submit(cameras, settings).take();
    replays += result.statistics.replays;
    expectFresh(result, scene, cameras, settings);
  }
  EXPECT_GE(replays, 9u) << "transforms and lights are data";
}

TEST_F(ReplayTest, OverflowsComeBetween) {
  scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  Renderer renderer(device(), scene, &sky());
  const auto blended = std::ranges::find_if(scene.instances, [&](const scene::Instance& instance) {
    return (scene.materials[instance.material].data.flags & shared::kMaterialBlended) != 0;
  });
  ASSERT_NE(blended, scene.instances.end());
  const scene::Instance card = *blended;
  const scene::Camera inFront = workshopCamera();
  uint32_t replays = 0;
  for (uint32_t call = 0; call < 8; ++call) {
    SCOPED_TRACE(call);
    if (call == 4)
      for (int i = 0; i < 100; ++i) addInstance(scene, card.mesh, card.material, card.toWorld);
    const std::vector<scene::Camera> cameras{inFront, camerasOf(call, 1).front()};
    const RenderResult result = renderer.submit(cameras, settings).take();
    replays += result.statistics.replays;
    expectFresh(result, scene, cameras, settings);
  }
  EXPECT_GE(replays, 3u);
}

// An overflow is detected after the next edits. The picture is rendered again with the scene as it was, and that is not
// replayed for the edited scene.
TEST_F(ReplayTest, OverflowsAreOfTheSceneAsItWasSubmitted) {
  scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  Renderer renderer(device(), scene, &sky());
  for (uint32_t call = 0; call < 3; ++call) renderer.render(camerasOf(call), settings);
  const auto blended = std::ranges::find_if(scene.instances, [&](const scene::Instance& instance) {
    return (scene.materials[instance.material].data.flags & shared::kMaterialBlended) != 0;
  });
  ASSERT_NE(blended, scene.instances.end());
  const scene::Instance card = *blended;
  for (int i = 0; i < 100; ++i) addInstance(scene, card.mesh, card.material, card.toWorld);
  const std::vector<scene::Camera> cameras(2, workshopCamera());
  Renderer fresh(device(), scene, &sky());
  const std::vector<output::FrameOutput> expected = fresh.render(cameras, settings);
  std::vector<Ticket> tickets;
  for (int i = 0; i < 3; ++i) tickets.push_back(renderer.submit(cameras, settings));
  scene::Material material = scene.materials[card.material];
  material.data.flags = 0;
  setMaterial(scene, card.material, material);
  for (Ticket& ticket : tickets) {
    const std::vector<output::FrameOutput> frames = ticket.take().frames;
    for (size_t i = 0; i < frames.size(); ++i) expectSame(frames[i], expected[i]);
  }
  for (uint32_t call = 0; call < 4; ++call)
    expectFresh(renderer.submit(cameras, settings).take(), scene, cameras, settings);
}

// The same commands run once at a time: each ticket in flight has its own.
TEST_F(ReplayTest, TicketsInFlight) {
  const scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  for (const auto& [ahead, results] : {std::pair<size_t, Results>{1, Results::ToHost}, {3, Results::OnDevice}}) {
    Renderer renderer(device(), scene, &sky());
    std::deque<Ticket> tickets;
    uint32_t replays = 0, taken = 0;
    const auto take = [&] {
      SCOPED_TRACE(taken);
      const RenderResult result = tickets.front().take();
      tickets.pop_front();
      replays += result.statistics.replays;
      expectFresh(result, scene, camerasOf(taken++), settings);
    };
    for (uint32_t call = 0; call < 9; ++call) {
      tickets.push_back(renderer.submit(camerasOf(call), settings, {}, results));
      if (tickets.size() > ahead) take();
    }
    while (!tickets.empty()) take();
    EXPECT_GE(replays, 3u);
  }
}

// A picture in flight shows the scene as it was submitted.
TEST_F(ReplayTest, EditsFollowBeforePicturesAreTaken) {
  scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  Renderer renderer(device(), scene, &sky());
  std::optional<Ticket> before;
  std::vector<output::FrameOutput> expected;
  for (uint32_t call = 0; call < 6; ++call) {
    SCOPED_TRACE(call);
    moveInstance(scene, 1);
    Ticket ticket = renderer.submit(camerasOf(call), settings);
    if (before) {
      const std::vector<output::FrameOutput> frames = before->take().frames;
      for (size_t i = 0; i < frames.size(); ++i) expectSame(frames[i], expected[i]);
    }
    before.emplace(std::move(ticket));
    Renderer fresh(device(), scene, &sky());
    expected = fresh.render(camerasOf(call), settings);
  }
}

// The bytes of the arrays of a request.
std::vector<std::vector<std::byte>> bytesOf(const RenderResult& result) {
  std::vector<std::vector<std::byte>> all;
  for (const ExportedArray& array : result.arrays) {
    const std::byte* data = array.memory->buffer.mapped();
    all.emplace_back(data, data + array.viewBytes() * array.views);
  }
  return all;
}

// Results that a caller still holds are not overwritten by later calls.
TEST_F(ReplayTest, ArraysBelongToTheirOwners) {
  if (!device().isCpu()) GTEST_SKIP() << "the host reads the arrays";
  const scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  Renderer renderer(device(), scene, &sky());
  RenderResult last;
  std::vector<std::vector<std::byte>> lastBytes;
  uint32_t replays = 0;
  for (uint32_t call = 0; call < 8; ++call) {
    SCOPED_TRACE(call);
    RenderResult result = renderer.submit(camerasOf(call), settings, {}, Results::Exported).take();
    replays += result.statistics.replays;
    if (call > 0) {
      EXPECT_EQ(bytesOf(last), lastBytes);
    }
    Renderer fresh(device(), scene, &sky());
    const RenderResult expected = fresh.submit(camerasOf(call), settings, {}, Results::Exported).take();
    lastBytes = bytesOf(result);
    EXPECT_EQ(lastBytes, bytesOf(expected));
    last = std::move(result);
  }
  EXPECT_GE(replays, 2u);
}

TEST_F(ReplayTest, SteadyCallsAllocateNothing) {
  scene::Scene scene = workshop();
  const Settings settings = replaySettings();
  vk::Device own({.selector = latelight::test::testDevice()});
  Renderer renderer(own, scene, &sky());
  uint64_t pipelines = 0, used = 0;
  size_t allocations = 0;
  for (uint32_t call = 0; call < 30; ++call) {
    SCOPED_TRACE(call);
    moveInstance(scene, call % 3);
    const RenderResult result = renderer.submit(camerasOf(call), settings).take();
    const auto memory = own.memory().statistics();
    if (call < 12) {
      pipelines = own.pipelinesMade();
      used = memory.usedBytes;
      allocations = memory.allocations;
      continue;
    }
    EXPECT_EQ(result.statistics.replays, 1u);
    EXPECT_EQ(own.pipelinesMade(), pipelines);
    EXPECT_EQ(memory.usedBytes, used);
    EXPECT_EQ(memory.allocations, allocations);
  }
}

}  // namespace
}  // namespace latelight::render::test
