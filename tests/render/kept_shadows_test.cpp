// The shadow map cache: shadow maps are redrawn if and only if necessary, and images equal those of a renderer without
// a cache, to the byte.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "render/frame/view.h"
#include "render/shadow/frame_shadows.h"
#include "render/support.h"
#include "scene/edit.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using output::Aov;

// Balls in a row over a floor, with a lamp above each ball that reaches no other ball.
constexpr uint32_t kBalls = 4;
constexpr float kApart = 6;
constexpr uint32_t kFloor = kBalls;  // index of the instance

scene::Scene ballsUnderLamps() {
  scene::SceneBuilder builder("balls");
  builder.scene.meshes = {sphereMesh(0.5f), squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", vec3(0.8f), 0, 1)};
  const auto at = [](uint32_t i) { return (static_cast<float>(i) - 0.5f * (kBalls - 1)) * kApart; };
  for (uint32_t i = 0; i < kBalls; ++i) {
    builder.addInstance("ball", builder.kRoot, 0, 0, glm::translate(glm::mat4(1), vec3(at(i), 0, 0)));
    scene::Light lamp;
    lamp.name = "lamp " + std::to_string(i);
    lamp.type = shared::kLightPoint;
    lamp.position = {at(i), 1.5f, 0};
    lamp.intensity = 20;
    lamp.range = 2.8f;
    builder.scene.lights.push_back(lamp);
  }
  const glm::mat4 flat = glm::rotate(glm::translate(glm::mat4(1), vec3(0, -1, 0)), -1.5707964f, vec3(1, 0, 0));
  builder.addInstance("floor", builder.kRoot, 1, 0, glm::scale(flat, vec3(20)));
  return std::move(builder.scene);
}

scene::Camera cameraAt(float x) {
  scene::Camera camera = frontPerspective(1.2f, 14);
  camera.toWorld = glm::translate(glm::dmat4(1), glm::dvec3(x, 3, 0)) * camera.toWorld;
  return camera;
}

Settings cacheSettings() {
  Settings settings = settingsOf(160, 90, {Aov::Color});
  settings.raster = Raster::Compute;
  settings.shadows = ShadowFormat::D32;
  settings.wholeShadowMaps = true;
  return settings;
}

class ShadowMapCacheTest : public RenderTest {
 protected:
  // Counts the maps that a frame must draw, and marks them as drawn.
  static size_t countDrawnMaps(const GpuScene& scene, const scene::Camera& camera, ShadowMapCache& kept,
                               const Settings& settings = cacheSettings()) {
    const shared::View view = makeView(camera, settings.width, settings.height);
    FrameShadows shadows = shadowsOf(scene, {&view, 1}, kept, settings);
    shadows.commit(ShadowMapState::Complete);
    return shadows.maps().size();
  }

  static FrameShadows shadowsOf(const GpuScene& scene, std::span<const shared::View> views, ShadowMapCache& kept,
                                const Settings& settings = cacheSettings()) {
    return {device(), scene, planShadows(shadowSceneOf(scene), views, settings), settings, kept};
  }
  // Expects the image of a fresh renderer. Returns whether shadow maps were drawn.
  static bool equalsFreshRenderer(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                                  const Settings& settings) {
    const RenderResult kept = renderer.submit({&camera, 1}, settings).take();
    EXPECT_EQ(imageOf(kept.frames.front(), Aov::Color).values,
              imageOf(renderOne(device(), scene, camera, settings), Aov::Color).values);
    return std::ranges::any_of(kept.statistics.passTimes, [](const auto& time) { return time.name == "shadow maps"; });
  }
};

TEST_F(ShadowMapCacheTest, OnlyChangedMapsAreRedrawn) {
  scene::Scene scene = ballsUnderLamps();
  GpuScene uploaded(device(), scene);
  ShadowMapCache kept;
  const auto now = [&] {
    uploaded.update({}, std::nullopt);
    return countDrawnMaps(uploaded, cameraAt(0), kept);
  };
  EXPECT_EQ(now(), 6 * kBalls);
  EXPECT_EQ(now(), 0u);
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0.1f), kept), 0u) << "the camera has moved";

  scene::setTransform(scene, 1, glm::translate(glm::mat4(1), vec3(-0.5f * kApart, -0.2f, 0)));
  EXPECT_EQ(now(), 1u) << "one ball has moved, below its lamp";
  scene::setTransform(scene, 1, glm::translate(glm::mat4(1), vec3(0.5f * kApart, -0.2f, 0)));
  EXPECT_EQ(now(), 2u) << "from the reach of one lamp to that of another";
  scene::setTransform(scene, 1, glm::translate(glm::mat4(1), vec3(0.5f * kApart - 1.2f, -0.2f, 0)));
  EXPECT_EQ(now(), 2u) << "from one face of its cube to that and another";
  scene::removeInstance(scene, 0);
  EXPECT_EQ(now(), 1u);
  scene::addInstance(scene, 0, 0, glm::translate(glm::mat4(1), vec3(0, 30, 0)));
  EXPECT_EQ(now(), 0u) << "out of all lamps' reach";

  scene::Light lamp = scene.lights[3];
  lamp.intensity *= 2;
  scene::setLight(scene, 3, lamp);
  EXPECT_EQ(now(), 0u) << "its light is not in its maps";
  lamp.position.y += 0.1f;
  scene::setLight(scene, 3, lamp);
  EXPECT_EQ(now(), 6u);

  scene::setMesh(scene, 0, sphereMesh(0.4f));
  EXPECT_EQ(now(), 3u) << "of all balls, of which none is left at the first two lamps";
  scene::setTransform(scene, kFloor, scene.instances[kFloor].toWorld);
  EXPECT_EQ(now(), 0u) << "put where it was";
  scene::Material material = scene.materials[0];
  material.data.flags |= shared::kMaterialMasked;
  scene::setMaterial(scene, 0, material);
  EXPECT_EQ(now(), 6 * kBalls);
}

TEST_F(ShadowMapCacheTest, DifferentSettingsRequireDifferentMaps) {
  const scene::Scene scene = ballsUnderLamps();
  const GpuScene uploaded(device(), scene);
  ShadowMapCache kept;
  Settings settings = cacheSettings();
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  settings.shadowFilter = ShadowFilter::Hard;  // with a different bias
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  settings.shadows = ShadowFormat::D16;
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  settings.shadows = ShadowFormat::Rgba8;
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  settings.shadows = ShadowFormat::Rgba8Classic;
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  settings.raster = Raster::Hardware;
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls);
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept, settings), 6 * kBalls) << "hardware keeps none";
}

// The tiles of the raster hardware, and the size of their layers, are those of a new cache after frames that required
// fewer, more, larger or smaller maps.
TEST_F(ShadowMapCacheTest, TilesOfHardwareDependOnNoEarlierFrame) {
  scene::Scene scene = ballsUnderLamps();
  scene.lights.push_back({.type = shared::kLightDirectional, .direction = glm::normalize(vec3(0.3f, -1, -0.2f))});
  const GpuScene uploaded(device(), scene);
  Settings settings = cacheSettings();
  settings.raster = Raster::Hardware;
  ShadowMapCache kept;
  const auto tilesIn = [&](ShadowMapCache& cache, std::span<const shared::View> views) {
    const FrameShadows shadows = shadowsOf(uploaded, views, cache, settings);
    std::vector<AtlasTile> tiles{{0, 0, 0, shadows.atlas().desc().width}};
    for (const FrameShadows::Map& map : shadows.maps()) tiles.push_back(map.tile);
    return tiles;
  };
  std::set<uint32_t> sides;
  for (const uint32_t size : {64u, 512u, 32u, 256u, 128u, 1024u, 64u, 64u})
    for (const size_t count : {size_t{1}, size_t{7}, size_t{2}}) {
      std::vector<shared::View> views;
      for (size_t i = 0; i < count; ++i) views.push_back(makeView(cameraAt(3 * static_cast<float>(i)), size, size));
      ShadowMapCache fresh;
      const std::vector<AtlasTile> tiles = tilesIn(kept, views);
      EXPECT_TRUE(tiles == tilesIn(fresh, views)) << count << " views of " << size;
      sides.insert(tiles.front().size);
    }
  EXPECT_GT(sides.size(), 2u);
}

// Each cascade of a sun is cached separately. The coarsest, which covers the whole scene, stays valid while the camera
// moves; the finer ones stay valid if the objects that move are outside of them.
TEST_F(ShadowMapCacheTest, CascadesAreCachedSeparately) {
  scene::Scene scene = ballsUnderLamps();
  scene.lights = {scene::Light{.type = shared::kLightDirectional, .direction = glm::normalize(vec3(0.3f, -1, -0.2f))}};
  GpuScene uploaded(device(), scene);
  ShadowMapCache kept;
  const auto at = [&](float x) {
    scene::Camera camera = frontPerspective(1.4f, 2);
    camera.toWorld = glm::translate(glm::dmat4(1), glm::dvec3(x, -0.5f, 0)) * camera.toWorld;
    uploaded.update({}, std::nullopt);
    return countDrawnMaps(uploaded, camera, kept);
  };
  at(0);
  EXPECT_EQ(at(0), 0u);
  const size_t moved = at(0.5f);
  EXPECT_GT(moved, 0u);
  EXPECT_LT(moved, 4u);
  EXPECT_EQ(at(0.5f), 0u);
  scene::setTransform(scene, 3, glm::translate(glm::mat4(1), vec3(1.5f * kApart, 0.5f, 0)));
  EXPECT_EQ(at(0.5f), 2u) << "a ball at the far end of the row, out of the finer ones";
  scene::setTransform(scene, 1, glm::translate(glm::mat4(1), vec3(0.7f, 0, 0)));
  EXPECT_EQ(at(0.5f), 4u) << "a ball that comes before the camera";
}

// Maps that overflowed or were never drawn are not in the cache.
TEST_F(ShadowMapCacheTest, IncompleteMapsAreRedrawn) {
  const scene::Scene scene = ballsUnderLamps();
  const GpuScene uploaded(device(), scene);
  ShadowMapCache kept;
  const shared::View view = makeView(cameraAt(0), 160, 90);
  EXPECT_EQ(shadowsOf(uploaded, {&view, 1}, kept).maps().size(), 6 * kBalls);
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept), 6 * kBalls);
  EXPECT_EQ(countDrawnMaps(uploaded, cameraAt(0), kept), 0u);
}

// Views that require equal maps of the same lights share them, at any position in the atlas.
TEST_F(ShadowMapCacheTest, ViewsShareMaps) {
  const scene::Scene scene = ballsUnderLamps();
  const GpuScene uploaded(device(), scene);
  ShadowMapCache kept;
  std::vector<shared::View> views;
  for (const float x : {0.0f, 0.05f, 0.1f}) views.push_back(makeView(cameraAt(x), 160, 90));
  const FrameShadows shadows = shadowsOf(uploaded, views, kept);
  EXPECT_EQ(shadows.maps().size(), 6 * kBalls);
  for (uint32_t light = 0; light < kBalls; ++light) EXPECT_EQ(shadows.of(0, light).first, shadows.of(2, light).first);
}

TEST_F(ShadowMapCacheTest, ImagesEqualThoseOfAFreshRenderer) {
  scene::Scene scene = ballsUnderLamps();
  Renderer renderer(device(), scene, nullptr);
  const Settings settings = cacheSettings();
  EXPECT_TRUE(equalsFreshRenderer(renderer, scene, cameraAt(0), settings));
  EXPECT_FALSE(equalsFreshRenderer(renderer, scene, cameraAt(0.2f), settings));
  scene::setTransform(scene, 2, glm::translate(glm::mat4(1), vec3(0.5f * kApart, 0.5f, 0)));
  EXPECT_TRUE(equalsFreshRenderer(renderer, scene, cameraAt(0.2f), settings));
  Settings sun = settings;
  sun.sun.emplace();
  EXPECT_TRUE(equalsFreshRenderer(renderer, scene, cameraAt(0.2f), sun));
  EXPECT_FALSE(equalsFreshRenderer(renderer, scene, cameraAt(0.2f), sun));
  EXPECT_FALSE(equalsFreshRenderer(renderer, scene, cameraAt(0.2f), settings));
}

// A camera approaches one lamp after another, so that sizes change and the atlas cannot hold all maps.
TEST_F(ShadowMapCacheTest, TheAtlasHoldsTheMapsOfThisFrame) {
  const scene::Scene scene = ballsUnderLamps();
  Renderer renderer(device(), scene, nullptr);
  Settings settings = cacheSettings();
  settings.shadowAtlas = 256;
  bool some = false, none = false;
  for (int step = 0; step < 24; ++step) {
    scene::Camera camera = frontPerspective(1.0f, 5 + 3 * static_cast<float>(step % 3));
    camera.toWorld =
        glm::translate(glm::dmat4(1), glm::dvec3(-9 + 0.75f * static_cast<float>(step), 0.5f, 0)) * camera.toWorld;
    (equalsFreshRenderer(renderer, scene, camera, settings) ? some : none) = true;
  }
  EXPECT_TRUE(some);
  for (int again = 0; again < 2; ++again) none = !equalsFreshRenderer(renderer, scene, cameraAt(0), settings);
  EXPECT_TRUE(none);
}

}  // namespace
}  // namespace latelight::render::test
