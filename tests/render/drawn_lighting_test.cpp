// The techniques that draw their lights (forward, forward-multipass, volumes) against fullscreen: lights in every
// position that a volume's faces, the near and far planes or the stencil test could handle incorrectly, over every kind
// of material.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <memory>
#include <tuple>

#include "render/base/readback.h"
#include "render/frame/view.h"
#include "render/frame_bench.h"
#include "render/lighting/forward/forward.h"
#include "render/lighting/volumes/volume_mesh.h"
#include "render/lighting/volumes/volumes.h"
#include "render/post/resolve.h"
#include "render/submit/frame_passes.h"
#include "render/support.h"
#include "scene/load/load.h"
#include "shared/light.h"
#include "shared/random.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using glm::vec4;

constexpr uint32_t kWidth = 128, kHeight = 80;

// --- frames with chosen lights --------------------------------------------------------------------------------------

struct LitPicture {
  std::vector<uint8_t> display;  // RGBA, the views in order
  std::vector<vec4> counts;      // empty if lights were not counted
};

// The largest difference of two images, in 8-bit codes.
int worstDifference(const LitPicture& a, const LitPicture& b) {
  if (a.display.size() != b.display.size()) return 256;
  int worst = 0;
  for (size_t i = 0; i < a.display.size(); ++i) worst = std::max(worst, std::abs(a.display[i] - b.display[i]));
  return worst;
}

struct LightRange {
  uint32_t first = 0, count = 0;
};

// One scene in device memory, lit by any range of its lights.
class Bench {
 public:
  Bench(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment = nullptr)
      : frames_(device, scene, environment),
        lights_(static_cast<uint32_t>(scene.lights.size())),
        intensity_(environment ? 0.5f : 0.0f) {}

  LightRange allLights() const { return {0, lights_}; }

  LitPicture light(const FrameConfig& setup, std::span<const shared::View> views, LightRange range) {
    frames_.shine(range.first, range.count);
    graph::Graph graph;
    const FrameContext f = frames_.frame(graph, setup, {views.begin(), views.end()},
                                         {.exposure = 1.25f, .environmentIntensity = intensity_});
    const LitFrame frame = addFrame(f);
    const ResultTarget finished = createResult(f, "picture", uint64_t{4} * f.width * f.height, f.viewCount());
    addCompose(f, frame.picture, {}, finished);
    const graph::BufferId display = addReadback(f, finished.buffer);
    graph::BufferId counts;
    if (setup.countLights) counts = addReadback(graph, frame.lightCounts);
    const graph::Submission& done = frames_.run(graph);
    const size_t pixels = size_t{kWidth} * kHeight * views.size();
    LitPicture picture;
    const uint8_t* bytes = done.buffer(display).as<uint8_t>();
    picture.display.assign(bytes, bytes + 4 * pixels);
    if (!setup.countLights) return picture;
    const vec4* values = done.buffer(counts).as<vec4>();
    picture.counts.assign(values, values + pixels);
    return picture;
  }

 private:
  FrameBench frames_;
  uint32_t lights_;
  float intensity_;
};

FrameConfig setupOf(const char* technique, const char* layout, uint32_t order = kVolumesClassic) {
  return {.layout = &findLayout(layout), .lighting = &findTechnique(technique), .volumesOrder = order};
}

// --- the room: a floor, a wall at y = 2, and every kind of material in front of it ----------------------------------

struct Room {
  scene::SceneBuilder builder{"room"};
  scene::Scene& scene = builder.scene;

  Room() {
    scene.meshes = {squareMesh(), sphereMesh(0.5f)};
    scene.textures.push_back(  // holes, for alpha masks
        textureOf(4, 4, true,
                  std::vector<glm::u8vec4>{{200, 90, 30, 255},
                                           {200, 90, 30, 0},
                                           {30, 90, 200, 255},
                                           {30, 90, 200, 0},
                                           {90, 200, 30, 0},
                                           {90, 200, 30, 255},
                                           {200, 200, 30, 0},
                                           {200, 30, 200, 255},
                                           {200, 90, 30, 255},
                                           {200, 90, 30, 255},
                                           {30, 90, 200, 0},
                                           {30, 90, 200, 255},
                                           {90, 200, 30, 255},
                                           {90, 200, 30, 0},
                                           {200, 200, 30, 255},
                                           {200, 30, 200, 255}}));
    scene.textures.push_back(textureOf(
        2, 2, false, {{90, 128, 230, 255}, {160, 100, 230, 255}, {128, 160, 240, 255}, {128, 128, 255, 255}}));
    const uint32_t plain = add({0.8f, 0.7f, 0.6f}, 0, 0.6f), metal = add({0.9f, 0.8f, 0.3f}, 1, 0.35f);
    const uint32_t bumpy = add({0.5f, 0.6f, 0.8f}, 0.2f, 0.5f), unlit = add({0.2f, 0.6f, 0.3f}, 0, 1);
    const uint32_t masked = add({1, 1, 1}, 0, 0.7f), twoSided = add({0.7f, 0.2f, 0.2f}, 0, 0.5f);
    const uint32_t glowing = add({0.1f, 0.1f, 0.1f}, 0, 0.4f);
    setTexture(scene.materials[bumpy], shared::kTextureNormal, 1);
    setTexture(scene.materials[masked], shared::kTextureBaseColor, 0, kNearest);
    scene.materials[unlit].data.flags |= shared::kMaterialUnlit;
    scene.materials[masked].data.flags |= shared::kMaterialMasked | shared::kMaterialDoubleSided;
    scene.materials[masked].data.alphaCutoff = 0.5f;
    scene.materials[twoSided].data.flags |= shared::kMaterialDoubleSided;
    scene.materials[glowing].data.emissive = {0.5f, 0.2f, 0.05f};

    // In glTF's frame, z = -2 is the world's y = 2.
    const glm::mat4 wall = glm::translate(glm::mat4(1), vec3(0, 0, -2)) * glm::scale(glm::mat4(1), vec3(4, 3, 1));
    place(0, plain, wall);
    const glm::mat4 lying = glm::rotate(glm::mat4(1), -1.5707963f, vec3(1, 0, 0));
    place(0, bumpy, glm::translate(glm::mat4(1), vec3(0, -1.5f, 0)) * lying * glm::scale(glm::mat4(1), vec3(4)));
    place(1, metal, glm::translate(glm::mat4(1), vec3(-1.6f, -0.9f, -0.6f)));
    place(1, unlit, glm::translate(glm::mat4(1), vec3(1.5f, -0.9f, -1)));
    place(1, glowing, glm::translate(glm::mat4(1), vec3(0, -1, 0.2f)));
    place(1, bumpy, glm::translate(glm::mat4(1), vec3(1.7f, 0.7f, -1)) * glm::scale(glm::mat4(1), vec3(-1, 1.2f, 1)));
    const glm::mat4 back = glm::rotate(glm::mat4(1), 3.5f, vec3(0, 1, 0)) * glm::scale(glm::mat4(1), vec3(0.5f));
    place(0, twoSided, glm::translate(glm::mat4(1), vec3(0, 0.6f, -1)) * back);
    place(0, masked, glm::translate(glm::mat4(1), vec3(-1.5f, 0.6f, -1)) * glm::scale(glm::mat4(1), vec3(0.6f)));
    // Three squares at the same position: their depths are equal, so the last one drawn is visible.
    const glm::mat4 tie = glm::translate(glm::mat4(1), vec3(1.1f, -0.3f, 0.3f)) * glm::scale(glm::mat4(1), vec3(0.3f));
    for (uint32_t material : {plain, metal, masked}) place(0, material, tie);
  }

  uint32_t add(vec3 color, float metallic, float roughness) {
    scene.materials.push_back(scene::plainMaterial("m", color, metallic, roughness));
    return static_cast<uint32_t>(scene.materials.size()) - 1;
  }
  void place(uint32_t mesh, uint32_t material, const glm::mat4& local) {
    builder.addInstance("thing", builder.kRoot, mesh, material, local);
  }
};

scene::Light pointLight(vec3 position, float range, float intensity, vec3 color = {1, 0.9f, 0.7f}) {
  scene::Light light;
  light.position = position;
  light.range = range;
  light.intensity = intensity;
  light.color = color;
  return light;
}

scene::Light spotLight(vec3 position, vec3 target, float range, float intensity, float outer) {
  scene::Light light = pointLight(position, range, intensity, {0.6f, 0.9f, 1});
  light.type = shared::kLightSpot;
  light.direction = glm::normalize(target - position);
  light.innerCone = 0.5f * outer;
  light.outerCone = outer;
  return light;
}

struct LightCase {
  std::string name;
  std::vector<scene::Light> lights;
  bool brightens = true;  // the lights make the first view brighter
  LightRange range{};
};

// World space. The first camera is at (0, -4, 0) and looks along y; its near plane is at y = -3.875.
std::vector<LightCase> lightCases() {
  scene::Light sun;
  sun.type = shared::kLightDirectional;
  sun.direction = glm::normalize(vec3(0.3f, 1, -0.8f));
  std::vector<LightCase> cases = {
      {"no lights", {}, false},
      {"directional", {sun}},
      {"camera inside the sphere", {pointLight({0, -3.5f, 0.3f}, 5, 6)}},
      {"camera inside the cone", {spotLight({0, -6, 0}, {0, 0, 0}, 9, 40, 0.7f)}},
      {"near plane cuts the sphere", {pointLight({1.2f, -2.9f, -0.4f}, 1.6f, 4)}},
      {"near plane cuts the cone", {spotLight({0.6f, -4.5f, -0.5f}, {0.5f, 0, -1}, 6, 30, 0.3f)}},
      {"behind the camera, reaching past it", {pointLight({0, -7, 0.5f}, 8.5f, 60)}},
      {"behind the camera, not reaching it", {pointLight({0, -7, 0.5f}, 2, 60)}, false},
      {"behind the wall", {pointLight({0.3f, 4.5f, 0}, 2.1f, 10)}, false},
      {"behind the wall, reaching through", {pointLight({0.3f, 3, 0}, 2.5f, 10)}},
      {"in the air before all surfaces", {pointLight({0, -2.5f, 0.5f}, 0.7f, 10)}, false},
      {"huge", {pointLight({1, -2, 2}, 1000, 10)}},
      {"far reach of a cone", {spotLight({0, -3, 2}, {0, 1, 0}, 500, 20, 1.2f)}},
      {"without a range", {[] {
         scene::Light light = pointLight({-1, -1, 1}, 1, 3);
         light.range.reset();
         return light;
       }()}},
      {"narrow cone", {spotLight({-1, -1, 1.5f}, {-1.6f, 0.6f, -0.9f}, 5, 80, 0.02f)}},
      {"wide cone", {spotLight({1, 0, 0.5f}, {1, 2, 0.5f}, 3, 5, 1.5f)}},
      {"cone at its widest for a cone", {spotLight({0, 1, 0.5f}, {0.2f, 2, 0.2f}, 2.5f, 5, 1.39f)}},
      {"tiny, at the wall", {pointLight({0.6f, 1.97f, 1.9f}, 0.12f, 0.05f)}},
  };
  LightCase row{"from a fraction of a pixel to twice the least that is marked", {}};
  for (int i = 0; i < 14; ++i) {  // at the wall, 8 pixels are about 1.2 m
    const float reach = 0.01f * std::pow(1.55f, static_cast<float>(i));
    row.lights.push_back(
        pointLight({-2.6f + 0.4f * static_cast<float>(i), 2 - 0.3f * reach, 1.2f}, reach, reach * reach));
  }
  cases.push_back(row);
  LightCase many{"300 that overlap", {}};
  shared::Random random(7);
  for (int i = 0; i < 300; ++i) {
    const vec3 position(random.uniform(-3, 3), random.uniform(-1, 2), random.uniform(-1.4f, 2));
    many.lights.push_back(i % 3
                              ? pointLight(position, 1.6f, 0.02f)
                              : spotLight(position, position + vec3(random.uniform(-1, 1), 1, -1), 2.5f, 0.04f, 0.6f));
  }
  cases.push_back(many);
  return cases;
}

std::vector<LightCase> addLights(scene::Scene& scene) {
  std::vector<LightCase> cases = lightCases();
  for (LightCase& c : cases) {
    c.range = {static_cast<uint32_t>(scene.lights.size()), static_cast<uint32_t>(c.lights.size())};
    scene.lights.insert(scene.lights.end(), c.lights.begin(), c.lights.end());
  }
  return cases;
}

// All views at once: perspective; orthographic; with a far plane just behind the wall, which cuts the volumes of the
// lights behind it; off-center, jittered and from the side.
std::vector<shared::View> roomViews() {
  scene::Camera front = frontPerspective(1.6f, 4);
  scene::Camera flat = frontCamera(2.2f, 4);
  scene::Camera near = front;
  near.farClip = 6.5f;
  scene::Camera aside = front;
  aside.toWorld = glm::translate(glm::mat4(1), vec3(-2, -3, 0.5f)) * glm::rotate(glm::mat4(1), -0.5f, vec3(0, 0, 1));
  aside.principal = {0.3f, -0.2f};
  return {makeView(front, kWidth, kHeight), makeView(flat, kWidth, kHeight), makeView(near, kWidth, kHeight),
          makeView(aside, kWidth, kHeight, {0.3f, -0.2f})};
}

class DrawnLightingTest : public RenderTest {
 protected:
  struct Stage {
    Room room;
    std::vector<LightCase> cases = addLights(room.scene);
    std::vector<shared::View> views = roomViews();
    scene::Environment environment = constantEnvironment();
    Bench dark, bright;
    explicit Stage(vk::Device& device) : dark(device, room.scene), bright(device, room.scene, &environment) {}
    // Images by fullscreen, one per case with all views.
    const std::vector<LitPicture>& expected(const char* layout) {
      std::vector<LitPicture>& pictures = expected_[layout];
      if (pictures.empty())
        for (const LightCase& c : cases) pictures.push_back(dark.light(setupOf("fullscreen", layout), views, c.range));
      return pictures;
    }
    const LightCase& find(std::string_view name) const {
      return *std::find_if(cases.begin(), cases.end(), [&](const LightCase& c) { return c.name == name; });
    }
    std::map<std::string, std::vector<LitPicture>> expected_;
  };
  static void SetUpTestSuite() { stage = std::make_unique<Stage>(device()); }
  static void TearDownTestSuite() { stage.reset(); }
  static std::unique_ptr<Stage> stage;

  // Compares every light case in every view with fullscreen on the same layout.
  static void compareInRoom(const FrameConfig& setup, const char* layout) {
    const std::vector<LitPicture>& expected = stage->expected(layout);
    for (size_t i = 0; i < stage->cases.size(); ++i) {
      const LightCase& c = stage->cases[i];
      SCOPED_TRACE(c.name);
      EXPECT_LE(worstDifference(stage->dark.light(setup, stage->views, c.range), expected[i]), 1);
      const auto &none = expected[0].display, &lit = expected[i].display;
      EXPECT_EQ(!std::equal(none.begin(), none.begin() + size_t{kWidth} * kHeight * 4, lit.begin()), c.brightens);
    }
    const LitPicture all = stage->bright.light(setupOf("fullscreen", layout), stage->views, stage->bright.allLights());
    EXPECT_LE(worstDifference(stage->bright.light(setup, stage->views, stage->bright.allLights()), all), 1);
  }
};
std::unique_ptr<DrawnLightingTest::Stage> DrawnLightingTest::stage;

TEST_F(DrawnLightingTest, ForwardIsFullscreenOnTheExactLayout) {
  compareInRoom(setupOf("forward", "exact"), "exact");
}

TEST_F(DrawnLightingTest, ForwardLoopsAgree) {
  TechniqueInfo plain = findTechnique("forward");
  plain.add = [](const FrameContext& f, const Gbuffer& gbuffer) { return addForward(f, gbuffer, ForwardLoop::Plain); };
  FrameConfig setup = setupOf("forward", "exact");
  setup.shading = 1;
  const LitPicture redistributed = stage->bright.light(setup, stage->views, stage->bright.allLights());
  setup.lighting = &plain;
  EXPECT_LE(worstDifference(stage->bright.light(setup, stage->views, stage->bright.allLights()), redistributed), 1);
}

TEST_F(DrawnLightingTest, ForwardMultipassIsFullscreenOnTheExactLayout) {
  compareInRoom(setupOf("forward-multipass", "exact"), "exact");
}

TEST_F(DrawnLightingTest, VolumesAreFullscreen) {
  for (auto [layout, order] :
       {std::pair{"thin", kVolumesClassic}, {"thin", kVolumesKillzone}, {"exact", kVolumesKillzone}}) {
    SCOPED_TRACE(fmt::format("{}, {}", layout, choices<VolumesOrder>()[order].name));
    compareInRoom(setupOf("volumes", layout, order), layout);
  }
}

TEST_F(DrawnLightingTest, BlinnPhongToo) {
  FrameConfig expected = setupOf("fullscreen", "exact");
  expected.shading = 1;
  const LightRange all = stage->bright.allLights();
  const LitPicture picture = stage->bright.light(expected, stage->views, all);
  for (const char* technique : {"forward", "forward-multipass", "volumes"}) {
    SCOPED_TRACE(technique);
    FrameConfig setup = setupOf(technique, "exact");
    setup.shading = 1;
    EXPECT_LE(worstDifference(stage->bright.light(setup, stage->views, all), picture), 1);
  }
}

// --- counts: which lights were culled -------------------------------------------------------------------------------

TEST_F(DrawnLightingTest, LightsAreCounted) {
  FrameConfig expected = setupOf("fullscreen", "exact");
  expected.countLights = true;
  const LightCase& many = stage->find("300 that overlap");
  const LitPicture reference = stage->dark.light(expected, stage->views, many.range);
  for (const char* technique : {"forward", "forward-multipass", "volumes"}) {
    SCOPED_TRACE(technique);
    FrameConfig setup = setupOf(technique, "exact");
    setup.countLights = true;
    const LitPicture picture = stage->dark.light(setup, stage->views, many.range);
    EXPECT_LE(worstDifference(picture, reference), 1);
    size_t different = 0;
    double tested = 0, used = 0;
    for (size_t i = 0; i < picture.counts.size(); ++i) {
      different += picture.counts[i].g != reference.counts[i].g;
      EXPECT_LE(picture.counts[i].g, picture.counts[i].r);
      EXPECT_LE(picture.counts[i].r, reference.counts[i].r);
      tested += picture.counts[i].r, used += picture.counts[i].g;
    }
    // Where a light fades to zero or grazes a surface, the last bit decides whether the surface receives light.
    EXPECT_LE(different, picture.counts.size() / 200);
    EXPECT_GT(used, 0);
    fmt::print("{}: {:.1f} lights tested and {:.1f} used per pixel\n", technique,
               tested / static_cast<double>(picture.counts.size()), used / static_cast<double>(picture.counts.size()));
  }
}

// The sum of lights shaded per pixel in the first view, for one case.
double testedBy(Bench& bench, std::span<const shared::View> views, uint32_t order, const LightCase& c) {
  FrameConfig setup = setupOf("volumes", "thin", order);
  setup.countLights = true;
  double tested = 0;
  for (const vec4& count : bench.light(setup, views.first(1), c.range).counts) tested += count.r;
  return tested;
}

TEST_F(DrawnLightingTest, StencilCullingRejects) {
  const auto tested = [&](uint32_t order, std::string_view name) {
    return testedBy(stage->dark, stage->views, order, stage->find(name));
  };
  for (uint32_t order : {kVolumesClassic, kVolumesKillzone}) {
    SCOPED_TRACE(choices<VolumesOrder>()[order].name);
    EXPECT_EQ(tested(order, "in the air before all surfaces"), 0);
    EXPECT_EQ(tested(order, "behind the camera, not reaching it"), 0);
    EXPECT_GT(tested(order, "near plane cuts the sphere"), 0);
  }
  // The classic order marks everything in front of a volume's far side; Killzone's order requires the near side as
  // well.
  EXPECT_GT(tested(kVolumesClassic, "behind the wall"), 0);
  EXPECT_EQ(tested(kVolumesKillzone, "behind the wall"), 0);
}

// --- meshes ---------------------------------------------------------------------------------------------------------

TEST(VolumeMesh, TheSphereHoldsTheUnitSphere) {
  const VolumeMesh mesh = makeVolumeMesh();
  ASSERT_EQ(mesh.sphere.indexCount, 3u * 80);
  for (uint32_t i = 0; i < mesh.sphere.indexCount; i += 3) {
    const auto corner = [&](uint32_t k) {
      return mesh.vertices[mesh.sphere.firstVertex + mesh.indices[mesh.sphere.firstIndex + i + k]];
    };
    const vec3 normal = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    EXPECT_GE(glm::dot(normal, corner(0)), kVolumeMargin - 1e-5f);  // outward-facing, and not closer to the center
    EXPECT_LE(glm::length(corner(0)), 1.15f);
  }
}

// --- the hall -------------------------------------------------------------------------------------------------------

void compareInHall(vk::Device& device, const char* source) {
  const scene::Scene scene = scene::load(source);
  Bench bench(device, scene);
  const shared::View view = makeView(cameraOf(scene, kWidth, kHeight), kWidth, kHeight);
  const auto light = [&](const FrameConfig& setup) { return bench.light(setup, {&view, 1}, bench.allLights()); };
  const LitPicture exact = light(setupOf("fullscreen", "exact")), thin = light(setupOf("fullscreen", "thin"));
  EXPECT_LE(worstDifference(light(setupOf("forward", "exact")), exact), 1);
  EXPECT_LE(worstDifference(light(setupOf("forward-multipass", "exact")), exact), 1);
  EXPECT_LE(worstDifference(light(setupOf("volumes", "exact")), exact), 1);
  for (uint32_t order : {kVolumesClassic, kVolumesKillzone})
    EXPECT_LE(worstDifference(light(setupOf("volumes", "thin", order)), thin), 1);
}

TEST_F(DrawnLightingTest, TheHallWithAHundredLights) {
  compareInHall(device(), "builtin:hall,triangles=60k,lights=100");
}

}  // namespace
}  // namespace latelight::render::test
