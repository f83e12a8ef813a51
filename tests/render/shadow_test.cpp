// Shadows: edges and penumbras at the positions given by geometry, the device's lookups against the host's, and plans
// that are stable while the camera moves.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "render/base/readback.h"
#include "render/frame/view.h"
#include "render/frame_bench.h"
#include "render/gbuffer/layout.h"
#include "render/shadow/cascades.h"
#include "render/shadow/choose.h"
#include "render/shadow/frame_shadows.h"
#include "render/support.h"
#include "shared/light.h"
#include "shared/shadow.h"

namespace latelight::render::test {
namespace {

using glm::vec2;
using glm::vec3;
using output::Aov;

constexpr uint32_t kShadowSize = 256;
constexpr float kHalf = 2;                         // half the image's extent, in meters
constexpr float kWall = 2, kOccluder = 1;          // y of their planes in world space
constexpr float kEdge = -0.5f;                     // x of the occluder's right edge
constexpr float kPixel = 2 * kHalf / kShadowSize;  // in meters

// A wall in the plane y = 2, and 1 m in front of it a board whose right edge is at x = -0.5; viewed along +y.
scene::Scene boardBeforeWall(const scene::Light& light) {
  scene::SceneBuilder builder("board");
  builder.scene.meshes = {squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", vec3(0.8f), 0, 1)};
  const auto place = [&](vec3 at, vec3 size) {
    builder.addInstance("board", builder.kRoot, 0, 0, glm::scale(glm::translate(glm::mat4(1), at), size));
  };
  place({0, 0, -kWall}, vec3(4));
  place({kEdge - 0.5f, 0, -kOccluder}, {0.5f, 2.5f, 1});
  builder.scene.lights = {light};
  return std::move(builder.scene);
}

scene::Light lightOf(uint32_t type, vec3 position, vec3 target) {
  scene::Light light;
  light.name = "light";
  light.type = type;
  light.position = position;
  light.direction = glm::normalize(target - position);
  light.intensity = type == shared::kLightDirectional ? 3.0f : 30.0f;
  light.innerCone = 0.9f, light.outerCone = 1.0f;
  return light;
}

Settings shadowSettings(const char* format, const char* filter) {
  Settings settings = settingsOf(kShadowSize, kShadowSize, {Aov::Color, Aov::Position, Aov::Normal});
  settings.layout = &findLayout("exact");
  settings.shadows = choiceNamed<ShadowFormat>(format).value();
  settings.shadowFilter = choiceNamed<ShadowFilter>(filter).value();
  settings.axes = Axes::ZUp;
  return settings;
}

struct Shadowed {
  output::FrameOutput frame;
  std::vector<float> factor;  // per pixel; -1 where no light arrives even without shadows
};

class ShadowTest : public RenderTest {
 protected:
  static Shadowed render(const scene::Scene& scene, const Settings& settings) {
    Renderer renderer(device(), scene, nullptr);
    const scene::Camera camera = frontCamera(kHalf, 4);
    Settings without = settings;
    without.shadows = ShadowFormat::None;
    const output::FrameOutput open = std::move(renderer.render({&camera, 1}, without).front());
    Shadowed result{std::move(renderer.render({&camera, 1}, settings).front()), {}};
    for (size_t i = 0; i < size_t{kShadowSize} * kShadowSize; ++i) {
      const float all = imageOf(open, Aov::Color).values[4 * i], some = imageOf(result.frame, Aov::Color).values[4 * i];
      result.factor.push_back(all > 0 ? some / all : -1);
    }
    return result;
  }

  // The shadow plan of the scene for the view of render().
  static ShadowPlan plan(const scene::Scene& scene, const Settings& settings) {
    const GpuScene uploaded(device(), scene);
    const shared::View view = makeView(frontCamera(kHalf, 4), kShadowSize, kShadowSize);
    return planShadows(shadowSceneOf(uploaded), {&view, 1}, settings);
  }
};

// The finest map of a light that contains the point, chosen as in findShadowMap() of glsl/shadow.glsl.
const shared::ShadowMap* mapAt(const ShadowPlan& plan, const scene::Light& light, vec3 p, uint32_t filter) {
  if (plan.of[0].lights.front().maps == 6) return &plan.maps[shared::shadowFace(p - vec3(light.position))];
  for (const shared::ShadowMap& m : plan.maps)
    if (shared::shadowInside(m, shared::shadowPoint(m, p).texel, shared::shadowReach(filter) + 0.5f)) return &m;
  return nullptr;
}

// The x at which the factor rises above `level` in the image's center row, to the right of `from`; in meters.
float crossing(const std::vector<float>& factor, float from, float level) {
  const size_t row = size_t{kShadowSize / 2} * kShadowSize;
  for (auto x = static_cast<size_t>((from + kHalf) / kPixel); x + 1 < kShadowSize; ++x) {
    const float a = factor[row + x], b = factor[row + x + 1];
    if (a < level && b >= level) return -kHalf + (static_cast<float>(x) + 0.5f + (level - a) / (b - a)) * kPixel;
  }
  return 1e9f;
}

struct EdgeCase {
  const char* name;
  scene::Light light;
  float edge;  // x of the shadow's edge, exact
};

std::vector<EdgeCase> edgeCases() {
  const vec3 at(-2, -1, 0.1f);
  // The line from the light over the board's edge to the wall.
  const float lit = at.x + (kEdge - at.x) * (kWall - at.y) / (kOccluder - at.y);
  return {{"directional", lightOf(shared::kLightDirectional, {-1, -1, 0}, {0, 0, 0}), kEdge + kWall - kOccluder},
          {"spot", lightOf(shared::kLightSpot, at, {0, kWall, 0}), lit},
          {"point", lightOf(shared::kLightPoint, at, {0, kWall, 0}), lit}};
}

TEST_F(ShadowTest, EdgesAreWithinATexelOfTheirPosition) {
  for (const EdgeCase& edge : edgeCases())
    for (const char* filter : {"hard", "pcf"}) {
      SCOPED_TRACE(fmt::format("{} light, {}", edge.name, filter));
      const scene::Scene scene = boardBeforeWall(edge.light);
      const Settings settings = shadowSettings("d32", filter);
      const ShadowPlan maps = plan(scene, settings);
      ASSERT_FALSE(maps.maps.empty());
      const vec3 place(edge.edge, kWall, 0);
      const shared::ShadowMap* map = mapAt(maps, edge.light, place, shared::kShadowFilterPcf);
      ASSERT_TRUE(map);
      // The footprint of a texel on the wall, across the edge.
      const vec3 step(1e-3f, 0, 0);
      const vec2 moved = shared::shadowPoint(*map, place + step).texel - shared::shadowPoint(*map, place - step).texel;
      const float footprint = 2e-3f / glm::length(moved);
      const Shadowed shadowed = render(scene, settings);
      const float found = crossing(shadowed.factor, kEdge + 0.1f, 0.5f);
      fmt::print("{} {}: edge at {:.4f}, exactly {:.4f}; a texel is {:.4f} m there\n", edge.name, filter, found,
                 edge.edge, footprint);
      EXPECT_LT(footprint, 0.07f);
      EXPECT_LE(std::abs(found - edge.edge), footprint);
      // Both sides are fully lit or fully dark, except near the edge and outside of the light's cone.
      const size_t row = size_t{kShadowSize / 2} * kShadowSize;
      for (size_t x = 0; x < kShadowSize; ++x) {
        const float at = -kHalf + (static_cast<float>(x) + 0.5f) * kPixel, factor = shadowed.factor[row + x];
        if (factor < 0 || std::abs(at - edge.edge) < 4 * footprint + kPixel || at < kEdge + 4 * footprint) continue;
        EXPECT_NEAR(factor, at > edge.edge ? 1.0f : 0.0f, 2e-3f) << at;
      }
    }
}

// A board of 4 mm that is 1 cm in front of a light, which reaches 350 m, casts a shadow although it is so close.
TEST_F(ShadowTest, OccludersNearALightCastShadows) {
  const vec3 at(-2, -1, 0.1f), target(1, kWall, 0), toward = glm::normalize(target - at);
  for (const uint32_t type : {shared::kLightSpot, shared::kLightPoint}) {
    scene::Scene scene = boardBeforeWall(lightOf(type, at, target));
    const auto place = [&](vec3 middle, float half) {
      scene.instances.push_back(scene.instances.front());
      scene.instances.back().toWorld =
          glm::dmat4(glm::scale(glm::translate(glm::mat4(1), middle), vec3(half))) * scene::toWorldFromGltf();
    };
    place({0, 600, 0}, 600);
    const Shadowed open = render(scene, shadowSettings("d32", "hard"));
    place(at + toward * 0.01f, 0.002f);
    const Shadowed shadowed = render(scene, shadowSettings("d32", "hard"));
    const auto factorAt = [](const Shadowed& s, float x, float z) {
      const auto column = static_cast<size_t>((x + kHalf) / kPixel), row = static_cast<size_t>((kHalf - z) / kPixel);
      return s.factor[row * kShadowSize + column];
    };
    // The shadow on the wall is 300 times as large and as far away: 0.6 m to each side of the light's target.
    EXPECT_NEAR(factorAt(open, target.x, target.z), 1, 1e-3f);
    for (const float offset : {-0.4f, 0.0f, 0.4f}) EXPECT_EQ(factorAt(shadowed, target.x, offset), 0) << offset;
    for (const float offset : {-1.5f, 1.5f}) EXPECT_NEAR(factorAt(shadowed, target.x, offset), 1, 1e-3f) << offset;
  }
}

// If a layout stores the sun's shadow in 8 bits, lighting uses the values that lookups returned.
TEST_F(ShadowTest, TheSunsShadowInTheGbufferIsTheSunsShadow) {
  const scene::Scene scene = boardBeforeWall(lightOf(shared::kLightDirectional, {-1, -1, 0.2f}, {0, 0, 0}));
  Settings settings = shadowSettings("d32", "pcf");
  const Shadowed expected = render(scene, settings);
  settings.layout = &findLayout("killzone2");
  ASSERT_GE(settings.layout->sunTarget, 0);
  const Shadowed kept = render(scene, settings);
  size_t between = 0, beyond = 0;
  for (size_t i = 0; i < kept.factor.size(); ++i) {
    between += expected.factor[i] > 0.1f && expected.factor[i] < 0.9f;
    // Half a level, plus half floats of the radiance. The layout's own normals and positions move edges slightly.
    beyond += std::abs(kept.factor[i] - expected.factor[i]) > 0.5f / 255 + 2e-2f;
  }
  EXPECT_GT(between, 500u);
  EXPECT_LE(beyond, between / 50);
}

// Targets are read without requesting a picture. Their light is that of a picture, with shadows.
TEST_F(ShadowTest, TheLightTargetOfEveryLayoutHasShadows) {
  const scene::Scene scene = boardBeforeWall(lightOf(shared::kLightDirectional, {-1, -1, 0.2f}, {0, 0, 0}));
  const scene::Camera camera = frontCamera(kHalf, 4);
  Renderer renderer(device(), scene, nullptr);
  for (const Layout& layout : layouts()) {
    if (!layout.hasTargets()) continue;
    for (const char* format : {"d32", "rays"}) {
      SCOPED_TRACE(fmt::format("{}, {}", layout.name, format));
      Settings settings = shadowSettings(format, "hard");
      settings.layout = &layout;
      const output::FrameOutput picture = std::move(renderer.render({&camera, 1}, settings).front());
      const std::vector<float>& expected = imageOf(picture, Aov::Color).values;
      settings.aovs = {Aov::Depth};
      const output::RawGbuffer raw = renderer.readTargets(camera, settings).gbuffer;
      const auto light = std::ranges::find(raw.targets, std::string("light"), &output::RawTarget::name);
      ASSERT_NE(light, raw.targets.end());
      size_t dark = 0;
      for (size_t i = 0; i < expected.size(); i += 4) {
        dark += expected[i] == 0;
        for (size_t c = i; c < i + 3; ++c) ASSERT_NEAR(light->values[c], expected[c], 2e-3f * expected[c]) << i / 4;
      }
      EXPECT_GT(dark, 1000u);
    }
  }
}

// The fraction of a unit disc's area on one side of a line at x.
float discFraction(float x) {
  return 0.5f + (x * std::sqrt(1 - x * x) + std::asin(x)) / shared::kPi;
}

TEST_F(ShadowTest, PenumbrasHaveTheWidthThatFollowsFromTheLight) {
  scene::Light spot = lightOf(shared::kLightSpot, {-1.5f, -1, 0}, {-1.5f, kWall, 0});
  scene::Light sun = lightOf(shared::kLightDirectional, {-1, -1, 0}, {0, 0, 0});
  for (float size : {0.15f, 0.3f}) {
    spot.size = size;
    sun.size = size;
    // The board is 2 m from the spot light and 1 m from the wall. The sun's path from board to wall is sqrt(2) m, and
    // the slanted wall stretches the penumbra by the same factor again.
    const float spotRadius = size * 0.5f, sunRadius = std::tan(0.5f * size) * 2;
    for (const auto& [name, light, radius, edge] :
         {std::tuple{"spot", spot, spotRadius, 0.0f}, {"sun", sun, sunRadius, 0.5f}}) {
      const Shadowed shadowed = render(boardBeforeWall(light), shadowSettings("d32", "pcss"));
      constexpr float kLow = -0.6f, kHigh = 0.6f;
      const float low = crossing(shadowed.factor, kEdge + 0.02f, discFraction(kLow));
      const float high = crossing(shadowed.factor, kEdge + 0.02f, discFraction(kHigh));
      const float width = high - low, exact = (kHigh - kLow) * radius;
      fmt::print("{} of size {}: penumbra {:.4f} m, exactly {:.4f} m, about {:.4f}\n", name, size, width, exact,
                 0.5f * (low + high));
      EXPECT_NEAR(width, exact, 0.15f * exact + kPixel) << name;
      EXPECT_NEAR(0.5f * (low + high), edge, 0.1f * radius + kPixel) << name;
    }
  }
}

// --- the host's copy of glsl/shadow.glsl ----------------------------------------------------------------------------

// A tile of the atlas.
struct HostMap {
  uint32_t size = 0;
  std::vector<float> depths;
  float at(int x, int y) const { return depths[static_cast<size_t>(y) * size + static_cast<size_t>(x)]; }
};

float hostPcf(const HostMap& map, vec2 texel, float depth) {
  const vec2 middle = glm::floor(texel);
  const vec3 across = shared::shadowWeights(texel.x - middle.x - 0.5f);
  const vec3 down = shared::shadowWeights(texel.y - middle.y - 0.5f);
  float lit = 0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      lit += map.at(int(middle.x) + x, int(middle.y) + y) >= depth ? across[x + 1] * down[y + 1] : 0.0f;
  return lit;
}

float hostFactor(const std::vector<HostMap>& maps, const ShadowPlan& plan, const scene::Light& light, vec3 p, vec3 n) {
  constexpr uint32_t kFilter = shared::kShadowFilterPcf;
  const shared::ShadowMap* m = mapAt(plan, light, p, kFilter);
  if (!m) return 1;
  const vec3 toLight =
      light.type == shared::kLightDirectional ? -light.direction : glm::normalize(vec3(light.position) - p);
  const float width = shared::shadowPoint(*m, p).width;
  const vec2 slope = shared::shadowSlope(*m, n, toLight);
  const shared::ShadowPoint at = shared::shadowPoint(*m, p + n * shared::shadowNormalOffset(slope, width, kFilter));
  const float depth = at.depth - m->depthSlack - shared::shadowReceiverBias(*m, slope, at.width, kFilter);
  return depth < 1 ? hostPcf(maps[static_cast<size_t>(m - plan.maps.data())],
                             glm::clamp(at.texel, 1.5f, m->size - 1.5f), depth)
                   : 1;
}

TEST_F(ShadowTest, DeviceAndHostLookupsAgree) {
  for (const EdgeCase& edge : edgeCases())
    for (const char* format : {"d32", "d16", "rgba8", "rgba8-classic"}) {
      SCOPED_TRACE(fmt::format("{} light, {}", edge.name, format));
      const scene::Scene scene = boardBeforeWall(edge.light);
      Settings settings = shadowSettings(format, "pcf");
      settings.raster = Raster::Hardware;  // the raster of FrameBench
      const uint32_t index = indexOf(settings.shadows);
      // Draws the maps again and reads them back.
      FrameBench bench(device(), scene);
      const shared::View view = makeView(frontCamera(kHalf, 4), kShadowSize, kShadowSize);
      ShadowMapCache kept;
      const FrameShadows shadows(device(), bench.scene(),
                                 planShadows(shadowSceneOf(bench.scene()), {&view, 1}, settings), settings, kept);
      const ShadowPlan& plan = shadows.plan();
      graph::Graph graph;
      FrameContext f = bench.frame(graph, {.shadowFormat = index, .shadowFilter = shared::kShadowFilterPcf}, {view});
      f.shadows = &shadows;
      const graph::ImageId drawn = graph.import(shadows.atlas(), std::nullopt);
      addShadowMaps(f, {}, drawn);
      const graph::BufferId read = addReadback(graph, drawn);
      const std::byte* texels = bench.run(graph).buffer(read).mapped();
      const vk::ImageDesc& atlas = shadows.atlas().desc();
      const auto depthAt = [&](size_t i) {
        const auto* bytes = reinterpret_cast<const uint8_t*>(texels + 4 * i);
        const auto packed = [&] { return shared::vec4(bytes[0], bytes[1], bytes[2], bytes[3]) / 255.0f; };
        if (index == shared::kShadowD32) return reinterpret_cast<const float*>(texels)[i];
        if (index == shared::kShadowD16)
          return static_cast<float>(reinterpret_cast<const uint16_t*>(texels)[i]) / 65535.0f;
        return index == shared::kShadowRgba8 ? shared::unpackDepth(packed()) : shared::unpackDepthClassic(packed());
      };
      std::vector<HostMap> maps(plan.maps.size());
      for (const FrameShadows::Map& map : shadows.maps()) {
        HostMap& host = maps[static_cast<size_t>(map.view - plan.views.data())];
        host.size = map.tile.size;
        for (size_t y = map.tile.y; y < map.tile.y + map.tile.size; ++y)
          for (size_t x = map.tile.x; x < map.tile.x + map.tile.size; ++x)
            host.depths.push_back(depthAt((map.tile.layer * atlas.height + y) * atlas.width + x));
      }

      const Shadowed shadowed = render(scene, settings);
      size_t lit = 0, dark0 = 0, beyond = 0;
      for (size_t i = 0; i < shadowed.factor.size(); ++i) {
        if (shadowed.factor[i] < 0) continue;
        const float expected = hostFactor(maps, plan, edge.light, vec3At(imageOf(shadowed.frame, Aov::Position), i),
                                          vec3At(imageOf(shadowed.frame, Aov::Normal), i));
        lit += expected > 0.9f;
        dark0 += expected < 0.1f;
        beyond += std::abs(shadowed.factor[i] - expected) > 4e-3f;
      }
      EXPECT_GT(lit, 2000u);
      EXPECT_GT(dark0, 2000u);
      // Only one side fuses products of floats, so a comparison at nearly equal depth may have either result.
      EXPECT_LE(beyond, 20u);
    }
}

// The samples of an image, ordered or temporal, look up maps that its first frame has drawn; the next image has its own
// maps.
TEST_F(ShadowTest, SamplesOfAnImageShareTheirMaps) {
  constexpr uint32_t kSmall = 64;
  const scene::Scene scene = boardBeforeWall(edgeCases().front().light);
  const scene::Camera camera = frontCamera(kHalf, 4), aside = frontCamera(kHalf * 0.8f, 4);
  for (const char* format : {"d32", "rgba8"})
    for (const char* aa : {"none", "ss2", "taa"}) {
      SCOPED_TRACE(fmt::format("{}, {}", format, aa));
      Settings settings = shadowSettings(format, "pcf");
      settings.width = settings.height = kSmall;
      settings.aa = readText<AntiAliasing>("--aa", aa);
      settings.describeGraph = true;
      settings.wholeShadowMaps = true;  // with pages, each sample draws those that no earlier sample looked up
      Renderer renderer(device(), scene, nullptr);
      const RenderResult result = renderer.submit({&camera, 1}, settings).take();
      const output::FrameOutput& first = result.frames.front();
      // The graph of the last sample.
      const std::string& graph = result.statistics.graphviz;
      EXPECT_EQ(graph.find("shadow maps") != std::string::npos, aa == std::string("none"));
      EXPECT_NE(graph.find("shadow atlas"), std::string::npos);
      EXPECT_EQ(std::ranges::count(result.statistics.passTimes, "shadow maps", &graph::PassTime::name), 1);
      const auto brightness = [&](float x) {  // of the center row; x in meters
        const auto column = static_cast<size_t>((x + kHalf) / (2 * kHalf) * kSmall);
        return imageOf(first, Aov::Color).values[4 * (kSmall / 2 * kSmall + column)];
      };
      EXPECT_EQ(brightness(0), 0) << "the wall is dark up to x = 0.5";
      EXPECT_GT(brightness(1), 0);
      const output::FrameOutput second = std::move(renderer.render({&aside, 1}, settings).front());
      EXPECT_EQ(imageOf(second, Aov::Color).values,
                imageOf(renderOne(device(), scene, aside, settings), Aov::Color).values);
    }
}

// Under each kind of light, a ball does not shadow those of its own points that face the light well, regardless of the
// slopes of its facets (no shadow acne).
TEST_F(ShadowTest, NothingShadowsItself) {
  scene::SceneBuilder builder("ball");
  builder.scene.meshes = {sphereMesh(1), squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", vec3(0.8f), 0, 1)};
  builder.addInstance("ball", builder.kRoot, 0, 0, glm::mat4(1));
  const glm::mat4 tilted = glm::rotate(glm::translate(glm::mat4(1), vec3(0, -1.4f, 0)), -1.4f, vec3(1, 0, 0));
  builder.addInstance("floor", builder.kRoot, 1, 0, glm::scale(tilted, vec3(3)));
  for (const auto& [type, from] : {std::pair{shared::kLightDirectional, vec3(-3, -2, 4)},
                                   {shared::kLightSpot, vec3(-1.5f, -2, 3)},
                                   {shared::kLightPoint, vec3(-1.5f, -2, 3)}})
    for (const char* filter : {"hard", "pcf", "pcss"}) {
      SCOPED_TRACE(fmt::format("light of type {}, {}", type, filter));
      scene::Light light = lightOf(type, from, {0, 0, 0});
      builder.scene.lights = {light};
      const Shadowed shadowed = render(builder.scene, shadowSettings("d32", filter));
      size_t facing = 0, wrong = 0;
      for (size_t i = 0; i < shadowed.factor.size(); ++i) {
        const vec3 p = vec3At(imageOf(shadowed.frame, Aov::Position), i);
        if (shadowed.factor[i] < 0 || glm::length(p) > 1.001f) continue;
        const vec3 toLight = type == shared::kLightDirectional ? -light.direction : glm::normalize(from - p);
        if (glm::dot(glm::normalize(p), toLight) < 0.25f) continue;  // adjacent facets differ by 11 degrees
        ++facing;
        wrong += shadowed.factor[i] < 0.99f;
      }
      EXPECT_GT(facing, 3000u);
      EXPECT_EQ(wrong, 0u);
    }
}

// --- plans ----------------------------------------------------------------------------------------------------------

ShadowPlan hallPlan(const GpuScene& uploaded, const scene::Camera& camera, const std::string& lights) {
  Settings settings;
  settings.shadowLights = readText<ShadowLights>("--shadow-lights", lights);
  const shared::View view = makeView(camera, 640, 360);
  return planShadows(shadowSceneOf(uploaded), {&view, 1}, settings);
}

TEST_F(ShadowTest, CascadesHoldStillWhileTheCameraMoves) {
  scene::Scene scene = boardBeforeWall(lightOf(shared::kLightDirectional, {1, -2, 4}, {0, 0, 0}));
  scene.instances.push_back(scene.instances.front());
  scene.instances.back().toWorld = glm::scale(glm::dmat4(1), glm::dvec3(60)) * scene.instances.back().toWorld;
  const GpuScene uploaded(device(), scene);
  scene::Camera camera = frontPerspective(1, 3);
  const ShadowPlan still = hallPlan(uploaded, camera, "auto");
  ASSERT_EQ(still.maps.size(), size_t{kCascades});
  for (int step = 1; step <= 20; ++step) {
    scene::Camera moved = camera;
    moved.toWorld = glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0.013, 0.007, -0.005) * double(step)),
                                0.003 * double(step), glm::dvec3(0.3, 0.2, 1)) *
                    camera.toWorld;
    const ShadowPlan now = hallPlan(uploaded, moved, "auto");
    ASSERT_EQ(now.maps.size(), still.maps.size());
    for (size_t i = 0; i < now.maps.size(); ++i) {
      const shared::ShadowMap &a = still.maps[i], &b = now.maps[i];
      EXPECT_EQ(a.texel, b.texel);
      EXPECT_EQ(vec3(a.across), vec3(b.across));
      EXPECT_EQ(vec3(a.down), vec3(b.down));
      EXPECT_EQ(a.away, b.away);
      EXPECT_EQ(a.depthScale, b.depthScale);
      for (const float shift : {b.across.w - a.across.w, b.down.w - a.down.w})
        EXPECT_NEAR(shift, std::round(shift), 2e-2f) << "texels, cascade " << i;
    }
  }
}

bool apart(const AtlasTile& a, const AtlasTile& b) {
  return a.layer != b.layer || a.x >= b.x + b.size || b.x >= a.x + a.size || a.y >= b.y + b.size || b.y >= a.y + a.size;
}

TEST_F(ShadowTest, TilesOfAnAtlasNeitherOverlapNorLeaveGaps) {
  constexpr uint32_t kSide = 256, kLayers = 2;
  AtlasTiles tiles(kSide, kLayers);
  std::vector<AtlasTile> taken;
  uint64_t texels = 0;
  for (const uint32_t size : {256u, 128u, 128u, 64u, 64u, 64u, 32u, 32u, 32u}) {
    taken.push_back(tiles.take(size).value());
    texels += uint64_t{size} * size;
  }
  while (const std::optional<AtlasTile> tile = tiles.take(32)) {
    taken.push_back(*tile);
    texels += 32 * 32;
  }
  EXPECT_EQ(texels, uint64_t{kLayers} * kSide * kSide);
  for (size_t i = 0; i < taken.size(); ++i) {
    EXPECT_LT(taken[i].layer, kLayers);
    EXPECT_LE(std::max(taken[i].x, taken[i].y) + taken[i].size, kSide);
    for (size_t j = 0; j < i; ++j) EXPECT_TRUE(apart(taken[i], taken[j])) << i << ", " << j;
  }
  // After all tiles are recycled, in any order, the free space consists of entire layers.
  for (size_t i = 0; i < taken.size(); ++i) tiles.recycle(taken[i * 7 % taken.size()]);
  for (uint32_t layer = 0; layer < kLayers; ++layer) EXPECT_TRUE(tiles.take(kSide));
  EXPECT_FALSE(tiles.take(32));
}

scene::Scene manyLights(uint32_t count) {
  scene::Scene scene = boardBeforeWall(lightOf(shared::kLightPoint, {-2, -1, 0}, {0, 0, 0}));
  scene.lights.resize(count, scene.lights.front());
  for (uint32_t i = 0; i < count; ++i) scene.lights[i].position.z = 1e-3f * static_cast<float>(i);
  return scene;
}

TEST_F(ShadowTest, TheAtlasLimitsTheNumberOfShadows) {
  const scene::Scene scene = manyLights(5000);
  const GpuScene uploaded(device(), scene);
  const ShadowPlan all = hallPlan(uploaded, frontPerspective(1, 3), "all");
  EXPECT_EQ(all.of[0].lights.size(), 4096u * 4096 / (6 * 32 * 32));
  EXPECT_EQ(hallPlan(uploaded, frontPerspective(1, 3), "auto").of[0].lights.size(), kAutomaticShadows);
  EXPECT_EQ(hallPlan(uploaded, frontPerspective(1, 3), "3").of[0].lights.size(), 3u);
  EXPECT_TRUE(hallPlan(uploaded, frontPerspective(1, 3), "none").maps.empty());
  EXPECT_THROW(hallPlan(uploaded, frontPerspective(1, 3), "moon"), Error);
}

TEST_F(ShadowTest, TheSceneChoosesWhichLightsCastShadows) {
  scene::Scene scene = manyLights(3);
  scene.lights[0].castShadow = false;
  scene.lights[2].castShadow = true;
  scene.lights[2].intensity = 1e-3f;
  const GpuScene uploaded(device(), scene);
  const auto chosen = [&](const char* lights) {
    std::vector<uint32_t> sources;
    const ShadowPlan plan = hallPlan(uploaded, frontPerspective(1, 3), lights);
    for (const ShadowPlan::Entry& entry : plan.of[0].lights)
      sources.push_back(uploaded.lights().set().sources[entry.light]);
    return sources;
  };
  EXPECT_EQ(chosen("all"), (std::vector<uint32_t>{2, 1}));
  EXPECT_EQ(chosen("1"), (std::vector<uint32_t>{2}));
}

// Lights with values that are not finite, with cones of angle 0, or with a range of nearly 0 emit nothing and cause no
// message. The other lights are not affected.
TEST_F(ShadowTest, InvalidLightsEmitNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  scene::Scene scene = boardBeforeWall(lightOf(shared::kLightPoint, {-2, -1, 0}, {0, 0, 0}));
  const scene::Light good = scene.lights.front();
  const Settings settings = shadowSettings("d32", "pcss");
  const Shadowed expected = render(scene, settings);
  for (int kind = 0; kind < 7; ++kind) {
    scene::Light bad = good;
    if (kind == 0) bad.position.x = kNan;
    if (kind == 1) bad.intensity = kNan;
    if (kind == 2) bad.intensity = kInfinity;
    if (kind == 3) bad.type = shared::kLightSpot, bad.innerCone = bad.outerCone = 0;
    if (kind == 4) bad.type = shared::kLightDirectional, bad.direction = vec3(kNan);
    if (kind == 5) bad.range = 1e-30f;
    if (kind == 6) bad.type = shared::kLightSpot, bad.direction = vec3(0), bad.intensity = 0;
    scene.lights.push_back(bad);
  }
  const Shadowed actual = render(scene, settings);
  EXPECT_EQ(imageOf(actual.frame, Aov::Color).values, imageOf(expected.frame, Aov::Color).values);
}

}  // namespace
}  // namespace latelight::render::test
