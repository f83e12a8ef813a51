// The outputs that visualize the work of --raster compute, against closed forms.
#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <map>
#include <set>

#include "render/support.h"
#include "render/visibility/compute/raster_push.h"
#include "scene/clusters.h"

namespace latelight::render::test {
namespace {

using glm::vec2;
using glm::vec3;
using output::Aov;

scene::Mesh meshOf(const std::vector<vec3>& positions, const std::vector<uint32_t>& indices) {
  scene::Mesh mesh = squareMesh();
  mesh.positions = positions;
  mesh.attributes.assign(positions.size(), mesh.attributes.front());
  mesh.indices = indices;
  return mesh;
}

scene::Material plain(uint32_t flags) {
  scene::Material material = scene::plainMaterial("plain", vec3(1), 0, 1);
  material.data.flags |= flags;
  return material;
}

scene::Scene sceneOf(scene::Mesh mesh, const std::vector<glm::mat4>& places, scene::Material material) {
  scene::SceneBuilder builder("raster");
  builder.scene.meshes.push_back(std::move(mesh));
  builder.scene.materials.push_back(std::move(material));
  for (const glm::mat4& place : places) builder.addInstance("mesh", builder.kRoot, 0, 0, place);
  return std::move(builder.scene);
}

class RasterOutputsTest : public RenderTest {
 protected:
  static output::FrameOutput renderBy(Raster raster, const scene::Scene& scene, const scene::Camera& camera,
                                      uint32_t size) {
    Settings settings =
        settingsOf(size, size, {Aov::RasterClasses, Aov::RasterClusters, Aov::RasterTriangles, Aov::RasterOverdraw});
    settings.raster = raster;
    return renderOne(device(), scene, camera, settings);
  }

  // Returns the outputs with the raster compute, and expects the same with hardware.
  static output::FrameOutput render(const scene::Scene& scene, const scene::Camera& camera, uint32_t size) {
    output::FrameOutput frame = renderBy(Raster::Compute, scene, camera, size);
    const output::FrameOutput hardware = renderBy(Raster::Hardware, scene, camera, size);
    for (size_t i = 0; i < frame.aovs.size(); ++i) EXPECT_EQ(frame.aovs[i].values, hardware.aovs[i].values);
    return frame;
  }
};

// --- classes --------------------------------------------------------------------------------------------------------

struct Box {  // the legs of a right triangle, in pixels
  uint32_t width, height, kind;
};

TEST_F(RasterOutputsTest, ClassesFollowTheBoxes) {
  constexpr uint32_t kSize = 256;
  const auto maxMedium = static_cast<uint32_t>(device().isCpu() ? shared::kMediumPixelsOfCpu : shared::kMediumPixels);
  const auto side = static_cast<uint32_t>(std::sqrt(maxMedium));
  const Box boxes[] = {{3, 3, shared::kRasterSmall},        {5, 5, shared::kRasterSmall},
                       {32, 1, shared::kRasterSmall},       {33, 1, shared::kRasterMedium},
                       {6, 6, shared::kRasterMedium},       {20, 20, shared::kRasterMedium},
                       {side, side, shared::kRasterMedium}, {119, 1, shared::kRasterMedium},
                       {120, 1, shared::kRasterLarge},      {side + 1, side + 1, shared::kRasterLarge},
                       {1000, 1000, shared::kRasterLarge}};
  std::vector<vec3> positions;
  std::vector<uint32_t> indices;
  float top = 0;
  for (const Box& box : boxes) {  // one below the other, with the right angles at the left
    const vec2 corner(-0.5f * kSize, 0.5f * kSize - top);
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(),
                     {vec3(corner, 0), vec3(corner - vec2(0, box.height), 0), vec3(corner + vec2(box.width, 0), 0)});
    indices.insert(indices.end(), {first, first + 1, first + 2});
    top += static_cast<float>(box.height);
  }
  const scene::Scene scene = sceneOf(meshOf(positions, indices), {glm::mat4(1)}, plain(0));
  const output::FrameOutput frame = render(scene, frontCamera(0.5f * kSize), kSize);
  std::set<uint32_t> shown;
  for (size_t i = 0; i < size_t{kSize} * kSize; ++i) {
    const vec2 kind = vec2At(imageOf(frame, Aov::RasterClasses), i);
    const vec2 triangle = vec2At(imageOf(frame, Aov::RasterTriangles), i);
    if (triangle.x == 0) {
      EXPECT_EQ(kind, vec2(0));
      continue;
    }
    const auto number = static_cast<uint32_t>(triangle.y);
    shown.insert(number);
    ASSERT_EQ(kind.x, boxes[number].kind) << number;
    ASSERT_NEAR(kind.y, 1, 1e-6f) << number;
  }
  EXPECT_EQ(shown.size(), std::size(boxes));
}

// A floor that extends from in front of the camera to behind it.
TEST_F(RasterOutputsTest, TrianglesThatCrossTheNearPlaneAreClipped) {
  constexpr uint32_t kSize = 64;
  constexpr float kFov = 1.2f;
  const scene::Scene scene = sceneOf(meshOf({{-9, -1, 0}, {9, -1, 0}, {0, -1, 30}}, {0, 1, 2}), {glm::mat4(1)},
                                     plain(shared::kMaterialDoubleSided));
  const output::FrameOutput frame = render(scene, frontPerspective(kFov, 8), kSize);
  size_t clipped = 0;
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    const vec2 kind = vec2At(imageOf(frame, Aov::RasterClasses), i);
    if (kind.x == 0) continue;
    ASSERT_EQ(kind.x, shared::kRasterClipped);
    const vec2 place = (vec2(i % kSize, i / kSize) + 0.5f) / float(kSize) * 2.0f - 1.0f;
    const vec3 ray(place * std::tan(0.5f * kFov), 1);
    EXPECT_NEAR(kind.y, std::abs(ray.y) / glm::length(ray), 1e-5f);
    ++clipped;
  }
  EXPECT_GT(clipped, kSize * kSize / 8);
}

// --- numbers --------------------------------------------------------------------------------------------------------

// The square [-1, 1]^2 in cells of two triangles each, row by row from the top.
scene::Mesh grid(uint32_t cells) {
  std::vector<vec3> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= cells; ++y)
    for (uint32_t x = 0; x <= cells; ++x)
      positions.push_back(vec3(2.0f * x / float(cells) - 1, 1 - 2.0f * y / float(cells), 0));
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = y * (cells + 1) + x, b = a + 1, c = a + cells + 1, d = c + 1;
      indices.insert(indices.end(), {a, c, b, b, c, d});
    }
  return meshOf(positions, indices);
}

TEST_F(RasterOutputsTest, NumbersAreThoseOfTheScene) {
  constexpr uint32_t kSize = 160, kCells = 20, kCell = kSize / 2 / kCells;
  const auto at = [](float x) { return glm::scale(glm::translate(glm::mat4(1), {x, 0, 0}), vec3(0.5f, 1, 1)); };
  const scene::Scene scene = sceneOf(grid(kCells), {at(-0.5f), at(0.5f)}, plain(0));
  const scene::Clusters clusters = scene::clustersOf(scene.meshes.front());
  const output::FrameOutput frame = render(scene, frontCamera(), kSize);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    const uint32_t x = i % kSize, y = i / kSize, instance = x / (kSize / 2) + 1;
    const uint32_t cell = y * kCells / kSize * kCells + x % (kSize / 2) / kCell;
    const vec2 triangle = vec2At(imageOf(frame, Aov::RasterTriangles), i);
    const vec2 cluster = vec2At(imageOf(frame, Aov::RasterClusters), i);
    ASSERT_EQ(triangle.x, instance);
    ASSERT_EQ(std::floor(triangle.y / 2), cell);
    ASSERT_EQ(cluster, vec2(instance, clusters.clusterOfTriangle[static_cast<size_t>(triangle.y)]));
  }
}

// --- overdraw -------------------------------------------------------------------------------------------------------

std::vector<glm::mat4> stack(uint32_t count) {
  std::vector<glm::mat4> places;
  for (uint32_t i = 0; i < count; ++i) places.push_back(glm::translate(glm::mat4(1), {0, 0, 0.1f * float(i)}));
  return places;
}

TEST_F(RasterOutputsTest, OverdrawOfStackedSquaresIsTheirNumber) {
  constexpr uint32_t kSize = 96;
  const std::map<uint32_t, uint32_t> kinds{
      {1, shared::kRasterLarge}, {6, shared::kRasterMedium}, {40, shared::kRasterSmall}};
  for (const auto& [cells, kind] : kinds)
    for (const uint32_t count : {1u, 3u, 17u}) {
      const scene::Scene scene = sceneOf(grid(cells), stack(count), plain(0));
      const output::FrameOutput frame = render(scene, frontCamera(0.97f), kSize);
      const std::vector<float>& overdraw = imageOf(frame, Aov::RasterOverdraw).values;
      EXPECT_EQ(std::ranges::count(overdraw, float(count)), kSize * kSize) << cells << " cells, " << count;
      EXPECT_EQ(imageOf(frame, Aov::RasterClasses).values[0], kind);
    }
}

// Back faces count if the material is double-sided. Masked-out fragments count, and blended ones do not.
TEST_F(RasterOutputsTest, OverdrawCountsRasterizedFragments) {
  constexpr uint32_t kSize = 32;
  const glm::mat4 turned = glm::rotate(glm::mat4(1), 3.14159265f, vec3(0, 1, 0));
  const auto overdrawn = [&](const glm::mat4& place, uint32_t flags, float alpha) {
    scene::Material material = plain(flags);
    material.data.baseColor.a = alpha;
    material.data.alphaCutoff = 0.5f;
    const output::FrameOutput frame =
        render(sceneOf(squareMesh(), {place}, std::move(material)), frontCamera(0.9f), kSize);
    const std::vector<float>& values = imageOf(frame, Aov::RasterOverdraw).values;
    EXPECT_EQ(std::ranges::count(values, values.front()), kSize * kSize);
    return std::pair(values.front(), imageOf(frame, Aov::RasterClasses).values.front());
  };
  constexpr float kLarge = shared::kRasterLarge;
  EXPECT_EQ(overdrawn(glm::mat4(1), 0, 1), std::pair(1.0f, kLarge));
  EXPECT_EQ(overdrawn(turned, 0, 1), std::pair(0.0f, 0.0f));
  EXPECT_EQ(overdrawn(turned, shared::kMaterialDoubleSided, 1), std::pair(1.0f, kLarge));
  EXPECT_EQ(overdrawn(glm::mat4(1), shared::kMaterialMasked, 0.4f), std::pair(1.0f, 0.0f));
  EXPECT_EQ(overdrawn(glm::mat4(1), shared::kMaterialBlended, 0.4f), std::pair(0.0f, 0.0f));
}

}  // namespace
}  // namespace latelight::render::test
