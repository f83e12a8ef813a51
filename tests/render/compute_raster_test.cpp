// Visibility in compute shaders: watertight, the same in every run, and what the graphics pipeline shows.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "models/models.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

using glm::vec2;
using glm::vec3;
using output::Aov;

Settings computeSettings(uint32_t width, uint32_t height, std::vector<Aov> aovs) {
  Settings settings = settingsOf(width, height, std::move(aovs));
  settings.raster = Raster::Compute;
  return settings;
}

// --- watertight -----------------------------------------------------------------------------------------------------

// Triangles in the plane z = 0, which cover a square from -1 to 1 once.
struct Cover {
  std::vector<vec2> points;
  std::vector<uint32_t> indices;
};

// A grid whose inner points are moved at random, and whose cells are parted by either diagonal.
Cover randomGrid(uint32_t cells, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> jitter(-0.45f, 0.45f);
  Cover cover;
  for (uint32_t y = 0; y <= cells; ++y)
    for (uint32_t x = 0; x <= cells; ++x) {
      const bool inner = x > 0 && x < cells && y > 0 && y < cells;
      const vec2 moved = inner ? vec2(jitter(random), jitter(random)) : vec2(0);
      cover.points.push_back((vec2(x, y) + moved) * (2.0f / static_cast<float>(cells)) - 1.0f);
    }
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = y * (cells + 1) + x, b = a + 1, c = a + cells + 1, d = c + 1;
      // Jitter keeps each quadrilateral simple, but only one of its diagonals may lie inside.
      const auto cross = [](vec2 u, vec2 v) { return u.x * v.y - u.y * v.x; };
      const auto& p = cover.points;
      const bool splits = cross(p[d] - p[a], p[b] - p[a]) * cross(p[d] - p[a], p[c] - p[a]) < 0;
      if (splits)
        cover.indices.insert(cover.indices.end(), {a, b, d, a, d, c});
      else
        cover.indices.insert(cover.indices.end(), {a, b, c, b, d, c});
    }
  return cover;
}

// Slivers around a point near the middle; a multiple of four, so that the square has its corners.
Cover fan(uint32_t slices, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> at(-0.3f, 0.3f);
  Cover cover{{{at(random), at(random)}}, {}};
  const auto rim = [&](float t) {  // once around the square
    const float side = std::fmod(t, 4.0f), s = 2 * (side - std::floor(side)) - 1;
    return side < 1 ? vec2(s, -1) : side < 2 ? vec2(1, s) : side < 3 ? vec2(-s, 1) : vec2(-1, -s);
  };
  for (uint32_t i = 0; i < slices; ++i)
    cover.points.push_back(rim(4 * static_cast<float>(i) / static_cast<float>(slices)));
  for (uint32_t i = 0; i < slices; ++i) {
    const uint32_t next = (i + 1) % slices;
    cover.indices.insert(cover.indices.end(), {0, 1 + i, 1 + next});
  }
  return cover;
}

// Half of the triangles in an instance, the others in another, by a bit of each one's hash: where both show a pixel, it
// was hit twice. Several bits tell any two triangles apart.
scene::Scene halves(const Cover& cover, uint32_t bit, uint32_t shown) {
  scene::builtin::SceneBuilder builder("cover");
  scene::Mesh mesh = squareMesh();
  mesh.positions.clear();
  for (const vec2 p : cover.points) mesh.positions.push_back(vec3(p, 0));
  mesh.attributes.assign(mesh.positions.size(), mesh.attributes.front());
  mesh.indices.clear();
  for (uint32_t t = 0; t < cover.indices.size() / 3; ++t) {
    const uint32_t hash = t * 2654435761u >> 16;
    if (shown == 2 || (hash >> bit & 1u) == shown)
      mesh.indices.insert(mesh.indices.end(), &cover.indices[3 * t], &cover.indices[3 * t] + 3);
  }
  builder.scene.meshes.push_back(std::move(mesh));
  scene::Material material = scene::builtin::plainMaterial("plain", vec3(1), 0, 1);
  material.data.flags |= shared::kMaterialDoubleSided;
  builder.scene.materials.push_back(material);
  builder.addInstance("cover", builder.kRoot, 0, 0, glm::mat4(1));
  return std::move(builder.scene);
}

class ComputeRasterTest : public RenderTest {
 protected:
  static std::vector<uint32_t> covered(const Cover& cover, uint32_t bit, uint32_t shown, const scene::Camera& camera,
                                       uint32_t size) {
    const scene::Scene scene = halves(cover, bit, shown);
    if (scene.meshes.front().indices.empty()) return std::vector<uint32_t>(size_t{size} * size, 0);
    return imageOf(renderOne(device(), scene, camera, computeSettings(size, size, {Aov::Id})), Aov::Id).ids;
  }

  // Every pixel that shows the square is hit once. `everywhere`: all of them show it.
  static void expectCoveredOnce(const Cover& cover, const scene::Camera& camera, uint32_t size,
                                bool everywhere = true) {
    const std::vector<uint32_t> all = covered(cover, 0, 2, camera, size);
    if (everywhere) EXPECT_EQ(std::ranges::count(all, 0u), 0) << "holes";
    EXPECT_LT(std::ranges::count(all, 0u), static_cast<std::ptrdiff_t>(all.size() * 9 / 10));
    for (uint32_t bit = 0; bit < 6; ++bit) {
      const std::vector<uint32_t> some = covered(cover, bit, 0, camera, size);
      const std::vector<uint32_t> others = covered(cover, bit, 1, camera, size);
      size_t twice = 0, never = 0;
      for (size_t i = 0; i < some.size(); ++i) {
        twice += some[i] && others[i];
        never += all[i] && !some[i] && !others[i];
      }
      EXPECT_EQ(twice, 0u);
      EXPECT_EQ(never, 0u);
    }
  }
};

TEST_F(ComputeRasterTest, MeshesCoverEachPixelOnce) {
  // From triangles of 200 pixels to those of a tenth of one.
  for (const uint32_t cells : {1u, 3u, 20u, 111u, 700u}) {
    SCOPED_TRACE(fmt::format("{} x {} cells", cells, cells));
    expectCoveredOnce(randomGrid(cells, cells), frontCamera(0.97f), 128);
  }
}

TEST_F(ComputeRasterTest, FansCoverEachPixelOnce) {
  for (const uint32_t slices : {4u, 60u, 2000u}) {
    SCOPED_TRACE(fmt::format("{} slices", slices));
    expectCoveredOnce(fan(slices, slices), frontCamera(0.97f), 200);
  }
}

// A floor that the camera stands on and looks along: triangles pass beside it and behind it, and every row of them
// crosses the near plane somewhere. Against a grid of a single cell, whose edges are its rim alone.
TEST_F(ComputeRasterTest, NothingOpensThroughTheNearPlane) {
  constexpr uint32_t kSide = 96;
  for (const float height : {0.05f, 0.001f})
    for (const float down : {0.0f, 0.3f, 1.2f}) {
      scene::Camera camera = frontPerspective(1.5f, height);
      const float angle = glm::half_pi<float>() - down, c = std::cos(angle), s = std::sin(angle);
      camera.toWorld = camera.toWorld * glm::mat4(1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, 0, 1);
      camera.nearClip = std::min(2e-3f, 0.3f * height);
      const std::vector<uint32_t> whole = covered(randomGrid(1, 0), 0, 2, camera, kSide);
      for (const uint32_t cells : {7u, 90u}) {
        SCOPED_TRACE(fmt::format("{} m above {} x {} cells, {} down", height, cells, cells, down));
        expectCoveredOnce(randomGrid(cells, 40 + cells), camera, kSide, false);
        EXPECT_EQ(covered(randomGrid(cells, 40 + cells), 0, 2, camera, kSide), whole);
      }
    }
}

// Triangles of 10,000 pixels and more, of which few are on screen.
TEST_F(ComputeRasterTest, HugeTrianglesCoverEachPixelOnce) {
  for (const float half : {1e-2f, 1e-4f}) {
    SCOPED_TRACE(half);
    expectCoveredOnce(randomGrid(3, 9), frontCamera(half), 96);
    expectCoveredOnce(fan(100, 11), frontCamera(half), 96);
  }
}

// --- against the graphics pipeline ----------------------------------------------------------------------------------

struct Difference {
  size_t pixels = 0, ids = 0;     // ids: that differ
  double depths = 0, albedo = 0;  // largest, where ids are the same; depth relative
};

class AgainstHardware : public RenderTest {
 protected:
  static Difference compare(const scene::Scene& scene, const scene::Camera& camera, uint32_t width, uint32_t height,
                            DataSurfaces surfaces = DataSurfaces::Opaque) {
    Settings settings = computeSettings(width, height, {Aov::Id, Aov::Part, Aov::Depth, Aov::GeoNormal, Aov::Albedo});
    settings.dataSurfaces = surfaces;
    const output::FrameOutput compute = renderOne(device(), scene, camera, settings);
    settings.raster = Raster::Hardware;
    const output::FrameOutput hardware = renderOne(device(), scene, camera, settings);
    Difference d{.pixels = size_t{width} * height};
    for (size_t i = 0; i < d.pixels; ++i) {
      if (imageOf(compute, Aov::Part).ids[i] != imageOf(hardware, Aov::Part).ids[i]) {
        ++d.ids;
        continue;
      }
      if (!imageOf(compute, Aov::Part).ids[i]) continue;
      const vec3 a = vec3At(imageOf(compute, Aov::GeoNormal), i), b = vec3At(imageOf(hardware, Aov::GeoNormal), i);
      if (glm::dot(a, b) < 0.999f) continue;  // another triangle of the same thing
      const double near = imageOf(compute, Aov::Depth).values[i], far = imageOf(hardware, Aov::Depth).values[i];
      d.depths = std::max(d.depths, std::abs(near - far) / far);
      const vec3 albedo = vec3At(imageOf(compute, Aov::Albedo), i) - vec3At(imageOf(hardware, Aov::Albedo), i);
      d.albedo = std::max(d.albedo, double{std::abs(albedo.x)});
    }
    return d;
  }
};

// The graphics pipeline rounds elsewhere, so that pixels whose centres lie on an edge, to 1/256, may differ.
TEST_F(AgainstHardware, TheSameSurfacesShow) {
  for (const char* model : {"textured.glb", "intricate.glb", "punctual.glb"}) {
    SCOPED_TRACE(model);
    const scene::Scene scene = scene::load(models::modelPath(model).string());
    const Difference d = compare(scene, cameraOf(scene, 240, 160), 240, 160);
    fmt::print("{}: {} of {} pixels show another surface\n", model, d.ids, d.pixels);
    EXPECT_LE(d.ids, d.pixels / 500);
  }
  const Difference d = compare(hall(), cameraOf(hall(), 240, 160), 240, 160);
  fmt::print("hall: {} of {} pixels show another surface, depths {:.1e} apart\n", d.ids, d.pixels, d.depths);
  EXPECT_LE(d.ids, d.pixels / 500);
}

TEST_F(AgainstHardware, BlendedSurfacesAsSolidOnes) {
  const scene::Scene scene = scene::load(models::modelPath("blended.glb").string());
  const Difference d = compare(scene, cameraOf(scene, 200, 150), 200, 150, DataSurfaces::Any);
  EXPECT_LE(d.ids, d.pixels / 500);
}

// Where two surfaces are at the very same depth, the one that is drawn later shows: by material, mesh, then number.
TEST_F(AgainstHardware, OfEqualDepthsTheLastOneShows) {
  scene::builtin::SceneBuilder builder("same");
  builder.scene.meshes = {squareMesh(), squareMesh()};
  for (const float red : {0.2f, 0.6f, 0.9f})
    builder.scene.materials.push_back(scene::builtin::plainMaterial(fmt::format("{}", red), vec3(red, 0, 0), 0, 1));
  const std::pair<uint32_t, uint32_t> kinds[] = {{1, 2}, {0, 1}, {1, 1}, {0, 0}, {0, 2}, {1, 0}};
  for (const auto& [mesh, material] : kinds) builder.addInstance("square", builder.kRoot, mesh, material, glm::mat4(1));
  const Difference d = compare(builder.scene, frontCamera(0.9f), 64, 64);
  EXPECT_EQ(d.ids, 0u);
  EXPECT_LT(d.albedo, 1e-6);
}

// --- the same in every run, at once and one by one ------------------------------------------------------------------

TEST_F(ComputeRasterTest, EveryRunGivesTheSameBytes) {
  Settings settings = computeSettings(200, 120, {Aov::Depth, Aov::Part, Aov::Normal, Aov::Color, Aov::Motion});
  settings.shadows = ShadowFormat::D32;
  const scene::Camera camera = cameraOf(hall(), 200, 120);
  Renderer renderer(device(), hall(), nullptr);
  const output::FrameOutput first = std::move(renderer.render({&camera, 1}, settings).front());
  for (int run = 0; run < 3; ++run) {
    const output::FrameOutput again = std::move(renderer.render({&camera, 1}, settings).front());
    for (const Aov aov : settings.aovs) {
      EXPECT_EQ(imageOf(again, aov).ids, imageOf(first, aov).ids);
      EXPECT_EQ(imageOf(again, aov).values, imageOf(first, aov).values) << output::info(aov).name;
    }
  }
}

TEST_F(ComputeRasterTest, ViewsAtOnceAreThoseOneByOne) {
  std::vector<scene::Camera> cameras(5, cameraOf(hall(), 96, 64));
  for (size_t i = 0; i < cameras.size(); ++i) {
    const float angle = 1.3f * static_cast<float>(i), c = std::cos(angle), s = std::sin(angle);
    cameras[i].toWorld = cameras[i].toWorld * glm::mat4(c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  }
  const Settings settings = computeSettings(96, 64, {Aov::Depth, Aov::Part, Aov::Albedo, Aov::Color});
  Renderer renderer(device(), hall(), nullptr);
  const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
  for (size_t i = 0; i < cameras.size(); ++i) {
    const output::FrameOutput alone = std::move(renderer.render({&cameras[i], 1}, settings).front());
    for (const Aov aov : settings.aovs) {
      EXPECT_EQ(imageOf(together[i], aov).ids, imageOf(alone, aov).ids);
      EXPECT_EQ(imageOf(together[i], aov).values, imageOf(alone, aov).values) << output::info(aov).name;
    }
  }
}

// Queues that are too small at first: the frame is rendered again, and lacks nothing.
TEST_F(ComputeRasterTest, WhatOverflowsIsDoneAgain) {
  const Cover cover = fan(20000, 3);
  const scene::Scene scene = halves(cover, 0, 2);
  const output::FrameOutput frame =
      renderOne(device(), scene, frontCamera(0.97f), computeSettings(512, 512, {Aov::Id}));
  EXPECT_EQ(std::ranges::count(imageOf(frame, Aov::Id).ids, 0u), 0);
}

}  // namespace
}  // namespace latelight::render::test
