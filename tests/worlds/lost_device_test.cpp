// The device is lost at each submission of worlds, of tickets in flight, and of rays. Each is an error of the call that
// needs the result, and a new renderer of the same scene returns the same bytes as before.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <functional>

#include "long_tests.h"
#include "lost_device/lose.h"
#include "test_device.h"
#include "worlds/tiny_views.h"

namespace latelight {
namespace {

using test::testDevice;

Options lostOptions() {
  return test::tinyOptions({"depth", "id"});
}

Worlds movedBoxes(const Scene& scene) {
  Worlds worlds{.count = 3, .instances = {scene.instances().front()}};
  for (int i = 0; i < 3; ++i) worlds.transforms.push_back({1, 0, 0, i * 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  worlds.cameras = {scene.defaultCamera(1.5f)};
  return worlds;
}

// The results of a call as bytes, so that different calls are tested alike.
using Bytes = std::string;
template <typename T>
void append(Bytes& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}
Bytes bytesOf(const std::vector<Frame>& frames) {
  Bytes bytes;
  for (const Frame& frame : frames) {
    append(bytes, frame.rgba);
    for (const auto& [name, aov] : frame.aovs) append(bytes, aov.values), append(bytes, aov.ids);
  }
  return bytes;
}

Bytes renderWorlds(const Scene& scene, Renderer& renderer) {
  return bytesOf(renderer.render(movedBoxes(scene), lostOptions()));
}

// Three tickets in flight, the second of which stays on the device until it is taken.
Bytes takeTickets(const Scene& scene, Renderer& renderer) {
  const Worlds worlds = movedBoxes(scene);
  std::vector<Ticket> tickets;
  for (const Results results : {Results::ToHost, Results::OnDevice, Results::ToHost})
    tickets.push_back(renderer.submit(worlds, lostOptions(), results));
  Bytes bytes;
  for (Ticket& ticket : tickets) bytes += bytesOf(ticket.take());
  return bytes;
}

Bytes castRays(const Scene& scene, Renderer& renderer) {
  const Camera camera = scene.defaultCamera(1.5f);
  const std::array<double, 3> eye{camera.cameraToWorld[3], camera.cameraToWorld[7], camera.cameraToWorld[11]};
  std::vector<std::array<double, 3>> origins(20, eye), directions;
  for (int i = 0; i < 20; ++i) directions.push_back({i * 0.05 - 0.5, -0.1, -1});
  const CastHits hits = renderer.cast(origins, directions);
  Bytes bytes;
  append(bytes, hits.distance), append(bytes, hits.id), append(bytes, hits.normal);
  return bytes;
}

// Calls `call` with a new renderer that loses its device at this submission. Returns false if it did not come to that.
bool loseAt(int submission, const Scene& scene, const std::function<Bytes(const Scene&, Renderer&)>& call,
            const Bytes& expected) {
  DevicesToLose devices;
  devices.loseAt(submission);
  const auto isLost = [&](const std::function<void()>& body) {
    try {
      body();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::DeviceLost) << error.what();
      EXPECT_THAT(error.what(), testing::HasSubstr("The device was lost"));
      return true;
    }
    return false;
  };
  std::optional<Renderer> renderer;
  const bool lost = isLost([&] {
    renderer.emplace(scene, testDevice());
    EXPECT_EQ(call(scene, *renderer), expected);
  });
  EXPECT_EQ(lost, devices.hasLost());
  if (!lost) return false;
  if (renderer) {
    EXPECT_TRUE(isLost([&] { call(scene, *renderer); })) << "a lost device returned results";
  }
  Renderer next(scene, testDevice());
  EXPECT_EQ(call(scene, next), expected);
  return true;
}

class LostDevices : public testing::TestWithParam<Bytes (*)(const Scene&, Renderer&)> {};

TEST_P(LostDevices, AreErrorsAndTheNextRendererWorks) {
  const Scene scene("builtin:boxes");
  Bytes expected;
  {
    Renderer renderer(scene, testDevice());
    expected = GetParam()(scene, renderer);
  }
  ASSERT_FALSE(expected.empty());
  const int step = test::rounds(1, 2);
  int losses = 0;
  for (int submission = 1; loseAt(submission, scene, GetParam(), expected); submission += step) {
    SCOPED_TRACE(submission);
    ++losses;
    if (HasFailure()) break;
  }
  EXPECT_GE(losses, 1);
}

INSTANTIATE_TEST_SUITE_P(Calls, LostDevices, testing::Values(renderWorlds, takeTickets, castRays));

}  // namespace
}  // namespace latelight
