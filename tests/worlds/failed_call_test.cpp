// Calls after one that failed: worlds of a call that was never submitted are not rendered by the next one.
#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <string>
#include <vector>

#include "placed.h"
#include "test_device.h"
#include "worlds/same_frames.h"
#include "worlds/tiny_views.h"

namespace latelight {
namespace {

using test::placed;
using test::testDevice;

// A square of half the width 0.5 in the plane z = 0.
struct SquareScene {
  Scene scene;
  Handle<Mesh> mesh = scene.addMesh({.name = "square",
                                     .positions = {{-.5, -.5, 0}, {.5, -.5, 0}, {.5, .5, 0}, {-.5, .5, 0}},
                                     .indices = {0, 1, 2, 0, 2, 3}});
  Handle<Instance> square = scene.addInstance(mesh, scene.addMaterial({.name = "white"}), placed(0, 0, 0));

  // Worlds that move the square by -1, 0 and 1 along X, in turn.
  Worlds moved(uint32_t count) const {
    Worlds worlds{.count = count, .instances = {square}, .cameras = {test::frontCamera()}};
    for (uint32_t world = 0; world < count; ++world)
      worlds.transforms.push_back(placed(static_cast<double>(world % 3) - 1, 0, 0));
    return worlds;
  }
};

Options idsBy(const std::string& raster, const std::string& shadows = "none") {
  Options options = test::tinyOptions({"id"});
  options.raster = raster;
  options.shadows = shadows;
  return options;
}

// Each world shows the square at its position only: the ids are 0 outside of its columns. The square is 5.5 pixels wide
// at the distance 4 of frontCamera(), whose field of view is 40 degrees, and so is the offset 1.
void expectMoved(const std::vector<Frame>& frames) {
  for (size_t world = 0; world < frames.size(); ++world) {
    const std::vector<uint32_t>& ids = frames[world].aovs.at("id").ids;
    ASSERT_EQ(ids.size(), size_t{24} * 16);
    double sum = 0, count = 0;
    for (size_t pixel = 0; pixel < ids.size(); ++pixel)
      if (ids[pixel] != 0) sum += static_cast<double>(pixel % 24) + 0.5, ++count;
    ASSERT_GT(count, 0) << "world " << world;
    const double side = sum / count - 12;
    EXPECT_EQ(side < -3 ? 0 : side > 3 ? 2 : 1, static_cast<int>(world % 3)) << "world " << world << ": " << side;
  }
}

constexpr uint32_t kWorlds = 512;  // of the calls that fail

// Renders images of 512 MiB within a limit of 256 MiB. They have a size at which shaders place worlds.
void failForMemory(Renderer& renderer, const Worlds& worlds, Options options) {
  options.width = options.height = 512;
  options.aovs = {"depth"};
  setMemoryLimit(uint64_t{256} << 20);
  try {
    renderer.render(worlds, options);
    ADD_FAILURE() << "there was memory for " << worlds.count << " worlds";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::OutOfMemory) << error.what();
  }
  setMemoryLimit(0);
}

TEST(FailedCall, LeavesWorldsThatTheHostPlacesAsTheyAre) {
  const SquareScene made;
  for (const char* shadows : {"none", "rays"}) {
    Renderer renderer(made.scene, testDevice());
    Worlds many = made.moved(kWorlds);
    many.transforms.clear();
    std::vector<double> elsewhere;
    for (uint32_t world = 0; world < many.count; ++world)
      for (const double number : {1., 0., 0., 9., 0., 1., 0., 0., 0., 0., 1., 0.}) elsewhere.push_back(number);
    many.arrays.transforms = {.element = WorldArray::Element::Float64, .rows = 3, .host = elsewhere.data()};
    Options lit = idsBy("compute", shadows);
    failForMemory(renderer, many, lit);
    std::vector<double>().swap(elsewhere);  // nothing may read it
    expectMoved(renderer.render(made.moved(3), idsBy("hardware")));
    expectMoved(renderer.render(made.moved(3), idsBy("compute", shadows)));
    expectMoved(renderer.render(made.moved(3), idsBy("rays")));
  }
}

TEST(FailedCall, DoesNotWriteToMemoryOfMoreWorlds) {
  const SquareScene made;
  Renderer renderer(made.scene, testDevice());
  for (uint32_t count = kWorlds + 1; count < 4 * kWorlds; count *= 2) {
    failForMemory(renderer, made.moved(kWorlds), idsBy("compute"));
    expectMoved(renderer.render(made.moved(count), idsBy("hardware")));
  }
}

// A cast of no rays submits nothing either.
TEST(FailedCall, AndACastOfNoRaysLeaveNothing) {
  const SquareScene made;
  Renderer renderer(made.scene, testDevice());
  Worlds worlds = made.moved(3);
  worlds.cameras.clear();
  for (auto& transform : worlds.transforms) transform = placed(9, 9, 9);
  const std::vector<double> none(3);
  const WorldArray numbers{.element = WorldArray::Element::Float64, .host = none.data()};
  renderer.cast(worlds, {numbers, numbers, 0}, std::vector<std::string>{"distance"});
  expectMoved(renderer.render(made.moved(3), idsBy("hardware")));
}

}  // namespace
}  // namespace latelight
