// Shadow maps of lights that arrays describe for each world, which shaders fit: random worlds have the bytes of the
// scene edited to their states, through the public API.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "long_tests.h"
#include "models/models.h"
#include "test_device.h"
#include "worlds/same_frames.h"

namespace latelight {
namespace {

using test::testDevice;
using enum WorldArray::Element;

constexpr uint32_t kCameras = 2;

// Random states of a scene's instances and lights, as arrays.
struct States {
  uint32_t count;
  Worlds worlds;
  std::vector<double> transforms, position;  // [count][instances][4][4], [count][lights][3]
  std::vector<float> poses, direction, color, intensity;

  States(const Scene& scene, uint32_t count, uint32_t seed);
  // The scene's lights from the third one on, and all of its instances, are those of a world.
  void edit(Scene& scene, uint32_t world) const;
  Camera cameraOf(uint32_t world, uint32_t camera) const;
};

Transform turned(std::mt19937& random, const Transform& at) {
  std::uniform_real_distribution<double> offset(-0.4, 0.4);
  const double angle = offset(random), c = std::cos(angle), s = std::sin(angle);
  Transform moved = at;
  for (size_t column = 0; column < 4; ++column) {
    moved[column] = c * at[column] + s * at[8 + column];
    moved[8 + column] = c * at[8 + column] - s * at[column];
  }
  for (const size_t axis : {3, 7, 11}) moved[axis] += offset(random);
  for (double& number : moved) number = static_cast<float>(number);
  return moved;
}

constexpr size_t kOwnLights = 2;  // lights that keep the scene's values in all worlds

States::States(const Scene& scene, uint32_t worldCount, uint32_t seed) : count(worldCount) {
  worlds = {.count = count, .instances = scene.instances(), .lights = scene.lights()};
  worlds.lights.erase(worlds.lights.begin(), worlds.lights.begin() + kOwnLights);
  worlds.cameras = {scene.lookAt({3, 2, 4}, {0, 0, 0}), scene.lookAt({-2, 3, 2}, {0, 0, 0})};
  worlds.cameras[1].orthographic = true;
  worlds.cameras[1].halfHeight = 2;
  worlds.cameras[1].farClip = 100;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(-3, 3), nearer(0.2, 3);
  std::uniform_real_distribution<float> share(0.1f, 1);
  for (uint32_t world = 0; world < count; ++world) {
    for (const Handle<Instance>& instance : worlds.instances)
      for (const double number : turned(random, scene.instance(instance).transform)) transforms.push_back(number);
    for (const Camera& camera : worlds.cameras) {
      Transform pose = turned(random, camera.cameraToWorld);
      for (const size_t axis : {3, 7, 11}) pose[axis] *= nearer(random);
      poses.insert(poses.end(), pose.begin(), pose.end());
    }
    for (const Handle<Light>& light : worlds.lights) {
      const Light own = scene.light(light);
      const bool keeps = random() % 4 == 0, up = random() % 8 == 0;  // up: along the axis that maps' own axes avoid
      for (size_t axis = 0; axis < 3; ++axis) position.push_back(keeps ? own.position[axis] : side(random));
      for (size_t axis = 0; axis < 3; ++axis)
        direction.push_back(keeps ? own.direction[axis] : up ? -float(axis == 1) : static_cast<float>(side(random)));
      for (size_t axis = 0; axis < 3; ++axis) color.push_back(share(random));
      intensity.push_back(random() % 4 ? own.intensity * share(random) : 0);
    }
  }
  for (size_t light = 0; light < worlds.lights.size(); ++light) intensity[light] = 0;  // of the first world
  worlds.arrays = {.transforms = {.element = Float64, .host = transforms.data()},
                   .cameraToWorld = {.element = Float32, .host = poses.data()},
                   .lightPosition = {.element = Float64, .host = position.data()},
                   .lightDirection = {.element = Float32, .host = direction.data()},
                   .lightColor = {.element = Float32, .host = color.data()},
                   .lightIntensity = {.element = Float32, .host = intensity.data()}};
}

void States::edit(Scene& scene, uint32_t world) const {
  const std::vector<Handle<Instance>> instances = scene.instances();
  for (size_t i = 0; i < instances.size(); ++i) {
    Transform transform;
    std::copy_n(transforms.begin() + static_cast<std::ptrdiff_t>((world * instances.size() + i) * 16), 16,
                transform.begin());
    scene.setTransform(instances[i], transform);
  }
  const std::vector<Handle<Light>> lights = scene.lights();
  for (size_t i = kOwnLights; i < lights.size(); ++i) {
    const size_t row = world * worlds.lights.size() + i - kOwnLights;
    Light light = scene.light(lights[i]);
    for (size_t axis = 0; axis < 3; ++axis) {
      light.position[axis] = position[3 * row + axis];
      light.direction[axis] = direction[3 * row + axis];
      light.color[axis] = color[3 * row + axis];
    }
    light.intensity = intensity[row];
    scene.setLight(lights[i], light);
  }
}

Camera States::cameraOf(uint32_t world, uint32_t camera) const {
  Camera result = worlds.cameras[camera];
  std::copy_n(poses.begin() + static_cast<std::ptrdiff_t>((world * kCameras + camera) * 16), 16,
              result.cameraToWorld.begin());
  return result;
}

// Suns, point lights, spot lights with one map and with a cube, and lights without shadows. `others`: number of further
// lights without shadows, among which those with shadows change their places in the light tree from world to world.
void addLights(Scene& scene, uint32_t others) {
  for (const Handle<Light>& light : scene.lights()) scene.removeLight(light);
  scene.addLight({.name = "fixed", .type = "point", .position = {1, 2, 1}, .intensity = 4});
  scene.addLight({.name = "fixed sun", .type = "directional", .direction = {0.3f, -1, 0.2f}, .intensity = 0.5f});
  scene.addLight({.name = "lamp", .type = "point", .position = {-1, 2, 1}, .intensity = 8});
  scene.addLight({.name = "open", .type = "point", .position = {0, 2, 2}, .intensity = 4, .castShadow = false});
  scene.addLight({.name = "sun", .type = "directional", .direction = {-0.6f, -1, 0.1f}, .intensity = 1});
  scene.addLight(
      {.name = "cone", .type = "spot", .position = {-1, 3, 1}, .direction = {0.3f, -1, -0.3f}, .intensity = 40});
  scene.addLight({.name = "wide",
                  .type = "spot",
                  .position = {1, 1.5, -1},
                  .direction = {-1, -0.4f, 1},
                  .intensity = 9,
                  .outerCone = 80,
                  .size = 0.1});
  scene.addLight({.name = "second sun", .type = "directional", .direction = {0.4f, -1, 0.5f}, .intensity = 1});
  scene.addLight({.name = "near", .type = "point", .position = {2, 1, -1}, .intensity = 8, .range = 4});
  for (uint32_t i = 0; i < others; ++i) {
    Light light{.name = "other", .position = {0.1 * i - 2, 2, 0.07 * i - 1}, .intensity = 0.2f, .castShadow = false};
    if (i % 5 == 4)
      light.type = "rect";
    else
      light.range = 0.5f + 0.2f * static_cast<float>(i % 7);
    scene.addLight(light);
  }
}

Options options(const char* raster, const char* shadows, const char* filter) {
  Options o;
  o.width = 40;
  o.height = 30;
  o.raster = raster;
  o.shadows = shadows;
  o.shadowFilter = filter;
  o.aovs = {"color", "depth"};
  return o;
}

// Renders the worlds three times, the third time by recorded commands. Compares one in `step` worlds each time.
void compare(const States& states, Scene& scene, Scene& edited, const Options& o, uint32_t step) {
  Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
  Options unshadowed = o;
  unshadowed.shadows = "none";
  const std::vector<Frame> lit = renderer.render(states.worlds, unshadowed);
  size_t shadowed = 0, compared = 0;
  for (uint32_t call = 0; call < 3; ++call) {
    const std::vector<Frame> frames = renderer.render(states.worlds, o);
    ASSERT_EQ(frames.size(), kCameras * states.count);
    for (uint32_t world = call % step; world < states.count && !testing::Test::HasFailure(); world += step) {
      states.edit(edited, world);
      for (uint32_t i = 0; i < kCameras; ++i, ++compared) {
        SCOPED_TRACE(testing::Message() << o.shadows << ", world " << world << ", camera " << i << ", call " << call);
        const Frame& frame = frames[kCameras * world + i];
        test::expectSameFrames(frame, alone.render(states.cameraOf(world, i), o));
        shadowed += frame.rgba != lit[kCameras * world + i].rgba ? 1 : 0;
      }
    }
  }
  EXPECT_GT(shadowed, compared / 2) << "something is in the shadow";
}

class ShadowsOfWorlds : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Rasters, ShadowsOfWorlds, testing::Values("compute", "hardware"),
                         [](const auto& info) { return std::string(info.param); });

// In all formats, and with all filters.
TEST_P(ShadowsOfWorlds, AreThoseOfTheEditedScene) {
  const bool compute = std::string(GetParam()) == "compute";
  const uint32_t count = compute ? latelight::test::rounds(200u, 9u) : 3;
  Scene scene("builtin:boxes"), edited("builtin:boxes");
  addLights(scene, 0);
  addLights(edited, 0);
  const States states(scene, count, 29);
  constexpr const char* kFormats[][2] = {{"d32", "pcf"}, {"d16", "pcss"}, {"rgba8-classic", "hard"}};
  for (const auto& [format, filter] : kFormats) compare(states, scene, edited, options(GetParam(), format, filter), 3);
}

// More lights than a word of shadow bits has, so that lights with shadows have other places in each world.
TEST_P(ShadowsOfWorlds, FollowTheOrderOfTheLightTree) {
  const bool compute = std::string(GetParam()) == "compute";
  Scene scene("builtin:boxes"), edited("builtin:boxes");
  addLights(scene, 70);
  addLights(edited, 70);
  States states(scene, compute ? 10 : 3, 31);
  states.worlds.arrays.lightDirection = {};  // with area lights, the host would convert them
  for (size_t i = 0; i < states.direction.size() / 3; ++i) {
    const Light own = scene.light(states.worlds.lights[i % states.worlds.lights.size()]);
    std::copy_n(own.direction.begin(), 3, states.direction.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  Options o = options(GetParam(), "d32", "pcf");
  o.aovs.emplace_back("lights-used");
  compare(states, scene, edited, o, 1);
}

// Lights that the caller names, or the most important ones, which differ from view to view: the host fits the latter.
TEST_P(ShadowsOfWorlds, AreOfSelectedLights) {
  Scene scene("builtin:boxes"), edited("builtin:boxes");
  addLights(scene, 4);
  addLights(edited, 4);
  const States states(scene, 4, 37);
  for (const char* selected : {"lamp,second sun", "3", "all"}) {
    SCOPED_TRACE(selected);
    Options o = options(GetParam(), "d32", "pcf");
    o.shadowLights = selected;
    compare(states, scene, edited, o, 1);
  }
}

// A world with a light that is not finite shows the background only, and changes no shadow of the others.
TEST(PlacedWorlds, ReportLightsWithShadowsThatAreNotFinite) {
  Scene scene("builtin:boxes");
  addLights(scene, 0);
  States states(scene, 3, 41);
  const Options o = options("compute", "d32", "pcf");
  Renderer renderer(scene, testDevice(), "studio");
  const std::vector<Frame> finite = renderer.render(states.worlds, o);
  const size_t second = states.worlds.lights.size();  // the first light of the second world
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const double position = std::exchange(states.position[3 * second + 1], wrong);
    Ticket ticket = renderer.submit(states.worlds, o);
    EXPECT_EQ(ticket.invalidWorlds(), std::vector<uint32_t>{1});
    const std::vector<Frame> frames = ticket.take();
    for (const size_t view : {0, 1, 4, 5}) test::expectSameFrames(frames[view], finite[view]);
    for (const float depth : frames[2].aovs.at("depth").values) EXPECT_TRUE(std::isinf(depth)) << depth;
    states.position[3 * second + 1] = position;
  }
  test::expectSameFrames(renderer.render(states.worlds, o)[2], finite[2]);
  states.intensity.back() = -1;
  EXPECT_THROW(renderer.render(states.worlds, o), Error);
}

}  // namespace
}  // namespace latelight
