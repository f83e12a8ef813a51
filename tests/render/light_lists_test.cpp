// Tiled and clustered light culling against fullscreen, per pixel: the images, and the number of contributing lights.
// Covers light lists that overflow, lights in difficult positions, and every kind of view.
#include "render/lighting/light_lists.h"

#include <fmt/core.h>

#include <random>

#include "render/base/readback.h"
#include "render/frame/view.h"
#include "render/frame_bench.h"
#include "render/submit/frame_passes.h"
#include "render/support.h"
#include "scene/half.h"
#include "scene/load/load.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using shared::vec3;

struct Picture {
  std::vector<uint16_t> light;  // half floats, four per pixel, all views
  std::vector<float> counts;    // tested, used, 0, 0
  double tested = 0, used = 0;  // per pixel, averaged over the pixels with a surface
};

// A scene in device memory, rendered with any technique.
class Stage {
 public:
  Stage(vk::Device& device, const scene::Scene& scene) : frames_(device, scene) {}
  GpuScene& scene() { return frames_.scene(); }

  Picture draw(const TechniqueInfo& technique, const char* layout, std::span<const scene::Camera> cameras,
               uint32_t width, uint32_t height) {
    std::vector<shared::View> views;
    for (const scene::Camera& camera : cameras) views.push_back(makeView(camera, width, height));
    const FrameConfig setup{.layout = &findLayout(layout), .lighting = &technique, .countLights = true};
    graph::Graph graph;
    const LitFrame lit = addFrame(frames_.frame(graph, setup, views));
    const graph::BufferId light = addReadback(graph, lit.picture), counts = addReadback(graph, lit.lightCounts);
    const graph::Submission& done = frames_.run(graph);
    const size_t values = size_t{width} * height * views.size() * 4;
    Picture picture;
    picture.light.assign(done.buffer(light).as<uint16_t>(), done.buffer(light).as<uint16_t>() + values);
    picture.counts.assign(done.buffer(counts).as<float>(), done.buffer(counts).as<float>() + values);
    average(picture);
    return picture;
  }

 private:
  static void average(Picture& picture) {
    double pixels = 0;
    for (size_t i = 0; i < picture.counts.size(); i += 4) {
      if (picture.light[i + 3] == 0) continue;
      ++pixels;
      picture.tested += picture.counts[i];
      picture.used += picture.counts[i + 1];
    }
    if (pixels > 0) picture.tested /= pixels, picture.used /= pixels;
  }

  FrameBench frames_;
};

float displayed(uint16_t half) {
  return shared::srgbFromLinear(shared::saturate(scene::floatFromHalf(half)));
}

// Expects a difference of at most 1/255 at every pixel. Lights are summed in one order, so only rounding may differ.
// Every light that fullscreen uses must contribute, however dim, except lights at the very edge of their reach.
void expectSame(const Picture& a, const Picture& reference) {
  ASSERT_EQ(a.light.size(), reference.light.size());
  float worst = 0;
  size_t otherLights = 0;
  for (size_t i = 0; i < a.light.size(); ++i)
    worst = std::max(worst, std::abs(displayed(a.light[i]) - displayed(reference.light[i])));
  for (size_t i = 0; i < a.light.size(); i += 4) {
    EXPECT_EQ(a.light[i + 3], reference.light[i + 3]);
    otherLights += a.counts[i + 1] != reference.counts[i + 1];
  }
  EXPECT_LE(worst, 1.0f / 255);
  EXPECT_LE(otherLights, a.light.size() / 4 / 10000) << worst;
}

void expectIdentical(const Picture& a, const Picture& b) {
  EXPECT_TRUE(a.light == b.light);
  EXPECT_TRUE(a.counts == b.counts);
}

// --- hard cases -----------------------------------------------------------------------------------------------------

// One view each: perspective with and without a far plane, orthographic, and off-center; the last view sees nothing.
std::vector<scene::Camera> manyCameras(const scene::Scene& scene) {
  std::vector<scene::Camera> cameras(5, scene.cameras.front());
  cameras[0].farClip = 40;
  cameras[1].orthographic = true;
  cameras[1].yHalf = 2.5f;
  cameras[1].farClip = 30;
  cameras[2].principal = {0.4f, -0.25f};
  cameras[2].toWorld[3] += glm::vec4(1, 0.5f, 0.5f, 0);
  cameras[4].toWorld[3] += glm::vec4(0, 0, 1000, 0);
  return cameras;
}

scene::Light pointLight(vec3 position, std::optional<float> range, float intensity = 0.3f) {
  scene::Light light;
  light.position = position;
  light.range = range;
  light.intensity = intensity;
  return light;
}

scene::Light spotLight(vec3 position, vec3 direction, float inner, float outer, std::optional<float> range) {
  scene::Light light = pointLight(position, range, 2);
  light.type = shared::kLightSpot;
  light.direction = glm::normalize(direction);
  light.innerCone = inner;
  light.outerCone = outer;
  return light;
}

scene::Light sun(vec3 direction) {
  scene::Light light;
  light.type = shared::kLightDirectional;
  light.direction = glm::normalize(direction);
  light.intensity = 0.2f;
  return light;
}

std::vector<scene::Light> hardLights(const scene::Scene& scene) {
  const glm::mat4 pose = scene.cameras.front().toWorld;
  const vec3 eye(pose[3]), forward(pose[1]);
  const scene::Bounds bounds = scene::worldBounds(scene);
  const vec3 center(bounds.center());
  std::vector<scene::Light> lights{
      pointLight(center, 1e6f),                                            // reaches everything
      pointLight(center + vec3(0, 0, 2), {}),                              // no range
      pointLight(eye, 0.5f),                                               // at the camera; reaches no surface
      pointLight(eye, 30.0f),                                              // the camera is inside
      pointLight(eye - forward * 3.0f, 2.0f),                              // behind the camera
      pointLight(eye - forward * 3.0f, 20.0f, 3),                          // behind the camera, reaching past it
      spotLight(eye, forward, 0, 0.02f, {}),                               // a few pixels wide
      spotLight(eye, forward, 0.3f, 0.3f, {}),                             // a hard edge
      spotLight(eye, -forward, 0, 1.5f, {}),                               // away from all visible surfaces
      spotLight(center + vec3(0, 0, 3), {0, 0, -1}, 0, 1.5707963f, 6.0f),  // a half-space
      spotLight(center + vec3(1, 0, 2), {0, 0.6f, -0.8f}, 0.2f, 0.6f, {}),
      sun({1, 2, -3}),
      sun({-1, 1, -1}),
  };
  std::mt19937 engine(3);
  const auto between = [&](float low, float high) { return std::uniform_real_distribution(low, high)(engine); };
  for (int i = 0; i < 600; ++i) {
    vec3 p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = between(static_cast<float>(bounds.min[axis]), static_cast<float>(bounds.max[axis]));
    const float size = std::exp2(between(-6, 1.5f));
    const std::optional<float> range = i % 5 ? std::optional(size) : std::nullopt;
    lights.push_back(
        i % 4 ? pointLight(p, range, 0.05f * size * size)
              : spotLight(p, {between(-1, 1), between(-1, 1), between(-1, 0.5f)}, 0, between(0.1f, 1.5f), range));
  }
  return lights;
}

const TechniqueInfo* const kTiled = &findTechnique("tiled");
const TechniqueInfo* const kClustered = &findTechnique("clustered");
const TechniqueInfo* const kFullscreen = &findTechnique("fullscreen");

template <uint32_t Cells, uint32_t Entries>
TechniqueInfo withCapacity() {
  return {
      .name = "small", .description = "lists of few lights", .add = [](const FrameContext& f, const Gbuffer& gbuffer) {
        return addLightLists(
            f, gbuffer, {.name = Cells == 1 ? "tiled" : "clustered", .cellsPerTile = Cells, .entriesPerTile = Entries});
      }};
}

class LightListsTest : public RenderTest {};

constexpr uint32_t kListWidth = 101, kListHeight = 59;  // not multiples of the tile size

TEST_F(LightListsTest, LightsInDifficultPositionsAreAllListed) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const std::vector<scene::Camera> cameras = manyCameras(scene);
  Stage stage(device(), scene);
  stage.scene().setLights(hardLights(scene));
  for (const char* layout : {"thin", "exact"}) {
    const Picture reference = stage.draw(*kFullscreen, layout, cameras, kListWidth, kListHeight);
    EXPECT_GT(reference.used, 5);
    for (const TechniqueInfo* technique : {kTiled, kClustered}) {
      SCOPED_TRACE(fmt::format("{}, {}", technique->name, layout));
      const Picture picture = stage.draw(*technique, layout, cameras, kListWidth, kListHeight);
      expectSame(picture, reference);
      EXPECT_LT(picture.tested, 0.3 * reference.tested);
      fmt::print("{}: {:.1f} tested, {:.1f} used of {:.0f}\n", technique->name, picture.tested, picture.used,
                 reference.tested);
    }
  }
}

TEST_F(LightListsTest, NoLightsOrOnlyDirectionalOnes) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Stage stage(device(), scene);
  for (const std::vector<scene::Light>& lights : {std::vector<scene::Light>{}, {sun({1, 2, -3}), sun({-1, 1, -1})}}) {
    stage.scene().setLights(lights);
    const Picture reference = stage.draw(*kFullscreen, "thin", manyCameras(scene), kListWidth, kListHeight);
    for (const TechniqueInfo* technique : {kTiled, kClustered}) {
      const Picture picture = stage.draw(*technique, "thin", manyCameras(scene), kListWidth, kListHeight);
      expectSame(picture, reference);
      EXPECT_EQ(picture.tested, static_cast<double>(lights.size()));
    }
  }
}

// If a list overflows, shaders read the same lights from the tree in the same order, so CPU devices return the same
// bits.
TEST_F(LightListsTest, OverflowingListsChangeNothing) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const std::vector<scene::Camera> cameras = manyCameras(scene);
  Stage stage(device(), scene);
  stage.scene().setLights(hardLights(scene));
  const std::pair<const TechniqueInfo*, std::vector<TechniqueInfo>> cases[] = {
      {kTiled, {withCapacity<1, 1>(), withCapacity<1, 12>()}},
      {kClustered, {withCapacity<kSlices, 1>(), withCapacity<kSlices, 12>(), withCapacity<kSlices, 40>()}}};
  for (const auto& [technique, small] : cases) {
    const Picture reference = stage.draw(*technique, "thin", cameras, kListWidth, kListHeight);
    for (const TechniqueInfo& other : small) {
      const Picture picture = stage.draw(other, "thin", cameras, kListWidth, kListHeight);
      expectSame(picture, reference);
      if (device().isCpu()) {
        EXPECT_TRUE(picture.light == reference.light);
      }
      EXPECT_NE(picture.tested, reference.tested);  // some lists overflowed
    }
  }
}

TEST_F(LightListsTest, TheSameBytesEachTime) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Stage stage(device(), scene);
  stage.scene().setLights(hardLights(scene));
  for (const TechniqueInfo& technique : {*kTiled, *kClustered, withCapacity<kSlices, 12>()})
    expectIdentical(stage.draw(technique, "thin", manyCameras(scene), kListWidth, kListHeight),
                    stage.draw(technique, "thin", manyCameras(scene), kListWidth, kListHeight));
}

TEST_F(LightListsTest, TheHallIsTheSameWithAnyNumberOfLights) {
  for (int lights : {1, 100, 10000}) {
    const scene::Scene scene = scene::load(fmt::format("builtin:hall,triangles=60k,lights={}", lights));
    Stage stage(device(), scene);
    const std::span<const scene::Camera> camera(scene.cameras.data(), 1);
    const char* layout = lights == 100 ? "exact" : "thin";
    const Picture reference = stage.draw(*kFullscreen, layout, camera, kListWidth, kListHeight);
    for (const TechniqueInfo* technique : {kTiled, kClustered}) {
      SCOPED_TRACE(fmt::format("{}, {}, {} lights", technique->name, layout, lights));
      const Picture picture = stage.draw(*technique, layout, camera, kListWidth, kListHeight);
      expectSame(picture, reference);
      if (lights == 10000) {
        EXPECT_LT(picture.tested, 0.05 * reference.tested);
      }
      fmt::print("{} lights, {}: {:.1f} tested, {:.1f} used\n", lights, technique->name, picture.tested, picture.used);
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
