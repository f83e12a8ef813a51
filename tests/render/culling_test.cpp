// Culling on the host, by the frustum and by size in pixels: it never culls visible instances, and culls nearly all
// others.
#include <gmock/gmock.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "render/base/frustum.h"
#include "render/frame/view.h"
#include "render/support.h"
#include "render/visibility/draw_order.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

constexpr uint32_t kCullingWidth = 64, kCullingHeight = 48;

// Distance of a point from the ray through a pixel's center, computed from the camera's definition in double precision
// without the renderer's matrices.
double distanceToRay(const scene::Camera& camera, dvec2 pixel, dvec3 point) {
  const double aspect = double(kCullingWidth) / kCullingHeight;
  const dvec2 ndc(2 * pixel.x / kCullingWidth - 1 - camera.principal.x,
                  1 - 2 * pixel.y / kCullingHeight - camera.principal.y);
  const glm::dmat4 pose(camera.toWorld);
  if (camera.orthographic) {
    const dvec3 from(pose * glm::dvec4(ndc.x * camera.yHalf * aspect, 0, ndc.y * camera.yHalf, 1));
    return glm::length(glm::cross(point - from, dvec3(pose[1])));
  }
  const double half = std::tan(camera.verticalFov / 2.0);
  const dvec3 direction = glm::normalize(dvec3(pose * glm::dvec4(ndc.x * half * aspect, 1, ndc.y * half, 0)));
  const dvec3 toPoint = point - dvec3(pose[3]);
  if (glm::dot(toPoint, direction) < 0) return glm::length(toPoint);
  return glm::length(glm::cross(toPoint, direction));
}

std::vector<scene::Camera> cameras() {
  std::vector<scene::Camera> all(4);
  all[0].toWorld = glm::translate(glm::mat4(1), vec3(0, -5, 0));
  all[1].toWorld = glm::rotate(glm::translate(glm::mat4(1), vec3(1, -4, 2)), 0.7f, glm::normalize(vec3(1, 2, 3)));
  all[1].principal = {0.3f, -0.4f};
  all[2].toWorld = all[0].toWorld;
  all[2].orthographic = true;
  all[2].yHalf = 3;
  all[3].toWorld = glm::translate(glm::mat4(1), vec3(1e5f, -1e5f, 1e5f));  // where float is coarse
  return all;
}

TEST(Culling, KeepsSpheresThatCoverAPixelCenter) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const scene::Camera& camera : cameras()) {
    const Frustum frustum(makeView(camera, kCullingWidth, kCullingHeight));
    unsigned seen = 0;
    for (int i = 0; i < 3000; ++i) {
      // A sphere around a point on the ray of some pixel's center, displaced by up to a few times its own radius.
      const dvec2 pixel(std::floor(unit(random) * kCullingWidth) + 0.5,
                        std::floor(unit(random) * kCullingHeight) + 0.5);
      const float radius = std::pow(10.0f, -4 + 4 * unit(random)), away = 0.5f + 12 * unit(random);
      const double half = std::tan(camera.verticalFov / 2.0);
      const dvec2 ndc(2 * pixel.x / kCullingWidth - 1 - camera.principal.x,
                      1 - 2 * pixel.y / kCullingHeight - camera.principal.y);
      const dvec2 extent =
          dvec2(camera.orthographic ? camera.yHalf : half * away) * dvec2(double(kCullingWidth) / kCullingHeight, 1);
      const vec3 offset = (vec3(unit(random), unit(random), unit(random)) - 0.5f) * 3.0f * radius;
      const vec3 center =
          vec3(glm::dmat4(camera.toWorld) * glm::dvec4(ndc.x * extent.x, away, ndc.y * extent.y, 1)) + offset;
      if (distanceToRay(camera, pixel, dvec3(center)) > radius) continue;
      ++seen;
      EXPECT_TRUE(frustum.holdsCenter({center, radius})) << i;
    }
    EXPECT_GT(seen, 300u);
  }
}

TEST(Culling, CullsNearlyAllSpheresSmallerThanPixels) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1, 1);
  const Frustum frustum(makeView(cameras().front(), kCullingWidth, kCullingHeight));
  unsigned kept = 0;
  for (int i = 0; i < 10000; ++i)  // each is 0.02 pixels wide; a quarter of a pixel on each side is kept for rounding
    kept += frustum.holdsCenter({vec3(unit(random), 0, unit(random)), 0.001f});
  EXPECT_LT(kept, 1200u);
}

class CullingTest : public RenderTest {};

// Squares of 0.6 pixels, many more of them than pixels: each pixel shows the nearest square that covers its center.
TEST_F(CullingTest, DrawsEveryVisibleInstance) {
  constexpr uint32_t kSide = 64, kCount = 40000;
  constexpr float kHalf = 0.3f / kSide * 2;  // half a square's side; the side is 0.6 pixels
  scene::Scene scene;
  scene.materials.push_back(scene::plainMaterial("grey", vec3(0.5f), 0, 1));
  scene.meshes.push_back(squareMesh());
  scene.nodes.push_back({.name = "squares", .path = "/squares"});
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<vec3> places;  // in glTF's frame
  for (uint32_t i = 0; i < kCount; ++i) {
    places.push_back({unit(random), unit(random), unit(random)});
    scene.instances.push_back({.id = i + 1});
    scene.instances.back().toWorld =
        scene::toWorldFromGltf() * glm::dmat4(glm::scale(glm::translate(glm::mat4(1), places[i]), vec3(kHalf)));
  }
  // The nearest square of each pixel, and whether an edge lies too close to the pixel's center to decide.
  std::vector<uint32_t> expected(kSide * kSide);
  std::vector<bool> unsure(kSide * kSide);
  for (uint32_t i = 0; i < kCount; ++i) {
    const dvec2 p((places[i].x + 1) / 2 * kSide, (1 - places[i].y) / 2 * kSide);
    for (int y = std::max(0, int(p.y) - 2); y <= std::min(int(kSide) - 1, int(p.y) + 2); ++y)
      for (int x = std::max(0, int(p.x) - 2); x <= std::min(int(kSide) - 1, int(p.x) + 2); ++x) {
        const double edge = std::max(std::abs(x + 0.5 - p.x), std::abs(y + 0.5 - p.y)) - 0.3;
        const size_t pixel = size_t(y) * kSide + size_t(x);
        uint32_t& nearest = expected[pixel];
        if (nearest != 0 && places[nearest - 1].z > places[i].z + 1e-5) continue;
        if (std::abs(edge) < 0.01) unsure[pixel] = true;
        if (edge >= 0) continue;
        if (nearest == 0 || places[i].z > places[nearest - 1].z) nearest = i + 1;
      }
  }
  const output::FrameOutput frame = renderOne(device(), scene, frontCamera(1, 4), settingsOf(kSide, kSide, {Aov::Id}));
  const std::vector<uint32_t>& ids = imageOf(frame, Aov::Id).ids;
  unsigned compared = 0;
  for (size_t pixel = 0; pixel < ids.size(); ++pixel) {
    if (unsure[pixel]) continue;
    ++compared;
    EXPECT_EQ(ids[pixel], expected[pixel]) << pixel;
  }
  EXPECT_GT(compared, kSide * kSide / 2);
  EXPECT_THAT(expected, testing::Contains(testing::Ne(0u)));
}

// The test counts operations, not time: most of the 202,500 instances, which cover no pixel center, must not be drawn.
TEST_F(CullingTest, DrawsFewOfManyInstances) {
  constexpr uint32_t kGrid = 450;
  scene::Scene scene;
  scene.materials.push_back(scene::plainMaterial("grey", vec3(0.5f), 0, 1));
  scene.meshes.push_back(squareMesh());
  scene.nodes.push_back({.name = "grid", .path = "/grid"});
  for (uint32_t i = 0; i < kGrid * kGrid; ++i) {
    scene.instances.push_back({.id = i + 1});
    const vec3 place = vec3(i % kGrid, i / kGrid, 0) * (2.0f / kGrid) - vec3(1, 1, 0);
    scene.instances.back().toWorld =
        scene::toWorldFromGltf() * glm::dmat4(glm::scale(glm::translate(glm::mat4(1), place), vec3(0.1f / kGrid)));
  }
  const GpuScene uploaded(device(), scene);
  DrawOrder order;
  order.update(uploaded);
  const shared::View view = makeView(frontCamera(1, 4), 64, 64);
  const Frustum frustum(view);
  const auto select = [&](bool atCenters) {
    return order.select(uploaded, DrawOrder::Kind::Solid, [&](const Sphere& bounds) {
      return frustum.touches(bounds) && (!atCenters || frustum.holdsCenter(bounds));
    });
  };
  EXPECT_EQ(select(false).instances.size(), kGrid * kGrid);
  EXPECT_LT(select(true).instances.size(), kGrid * kGrid / 4);
  // All instances share one draw call, although several threads select them.
  EXPECT_EQ(select(false).draws.size(), 1u);
  EXPECT_TRUE(std::ranges::is_sorted(select(true).instances));
}

// Only the last one of several opaque instances with the same mesh, material and transform is drawn.
TEST_F(CullingTest, DrawsOneOfManyAtTheSamePosition) {
  scene::Scene scene;
  scene.materials.push_back(scene::plainMaterial("grey", vec3(0.5f), 0, 1));
  scene.materials.push_back(scene.materials.front());
  scene.materials.back().data.flags |= shared::kMaterialBlended;
  scene.materials.back().data.baseColor.a = 0.5f;
  scene.meshes.push_back(squareMesh());
  scene.nodes.push_back({.name = "pile", .path = "/pile"});
  for (uint32_t i = 0; i < 100; ++i) scene.instances.push_back({.material = i / 50, .id = i + 1});
  for (scene::Instance& instance : scene.instances) instance.toWorld = scene::toWorldFromGltf();
  const GpuScene uploaded(device(), scene);
  DrawOrder order;
  order.update(uploaded);
  const scene::Camera camera = frontCamera(1, 4);
  const auto all = [](const Sphere&) { return true; };
  EXPECT_EQ(order.select(uploaded, DrawOrder::Kind::Solid, all).instances, std::vector<uint32_t>{49});
  EXPECT_EQ(order.select(uploaded, DrawOrder::Kind::Blended, all).instances.size(), 50u);  // these accumulate
  const output::FrameOutput frame = renderOne(device(), scene, camera, settingsOf(8, 8, {Aov::Id}));
  EXPECT_THAT(imageOf(frame, Aov::Id).ids, testing::Each(50u));
}

}  // namespace
}  // namespace latelight::render::test
