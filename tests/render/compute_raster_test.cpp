// Software rasterization in compute shaders: watertight, the same in every run, and equal to the graphics pipeline,
// with one and with several samples per pixel.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "long_tests.h"
#include "models/models.h"
#include "render/support.h"
#include "scene/load/load.h"
#include "shared/samples.h"

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

// Triangles in the plane z = 0 that cover the square from -1 to 1 exactly once.
struct Cover {
  std::vector<vec2> points;
  std::vector<uint32_t> indices;
};

// A grid whose inner points are displaced at random by up to `maxJitter` of a cell. Each cell is split by a diagonal
// that lies inside.
Cover randomGrid(uint32_t cells, uint32_t seed, float maxJitter = 0.45f) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> jitter(-maxJitter, maxJitter);
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
      // Jitter keeps each quadrilateral simple, but possibly only one of its diagonals lies inside.
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

// Slivers around a point near the center. `slices` is a multiple of four, so that the square has its corners.
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

// Splits the triangles into two sets by one bit of each triangle's hash and returns one set as an instance, or all
// triangles if `shown` is 2. A pixel covered by both sets was hit twice. Several bits separate any two triangles.
scene::Scene halves(const Cover& cover, uint32_t bit, uint32_t shown) {
  scene::SceneBuilder builder("cover");
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
  scene::Material material = scene::plainMaterial("plain", vec3(1), 0, 1);
  material.data.flags |= shared::kMaterialDoubleSided;
  builder.scene.materials.push_back(material);
  builder.addInstance("cover", builder.kRoot, 0, 0, glm::mat4(1));
  return std::move(builder.scene);
}

// The parameter is the number of samples per pixel.
class ComputeCoverage : public RenderTest, public testing::WithParamInterface<uint32_t> {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (GetParam() == 4) LATELIGHT_SKIP_UNLESS_ALL();  // 16 samples are rasterized in the same way
  }
  // Returns the number of covered samples per pixel.
  static std::vector<uint32_t> covered(const scene::Scene& scene, const scene::Camera& camera, uint32_t size) {
    const uint32_t samples = GetParam();
    std::vector<uint32_t> counts(size_t{size} * size, 0);
    if (scene.meshes.front().indices.empty()) return counts;
    Settings settings = computeSettings(size, size, {samples == 1 ? Aov::Id : Aov::Color});
    settings.aa.samples = samples;
    const output::FrameOutput frame = renderOne(device(), scene, camera, settings);
    for (size_t i = 0; i < counts.size(); ++i)
      counts[i] = samples == 1 ? imageOf(frame, Aov::Id).ids[i] != 0
                               : static_cast<uint32_t>(
                                     imageOf(frame, Aov::Color).values[4 * i + 3] * static_cast<float>(samples) + 0.5f);
    return counts;
  }

  // Expects that each sample inside the square is hit exactly once. `everywhere`: all samples are inside. `folds`: the
  // number of pixels that may have samples that are hit more often.
  static void expectCoveredOnce(const Cover& cover, const scene::Camera& camera, uint32_t size, bool everywhere = true,
                                size_t folds = 0) {
    const std::vector<uint32_t> all = covered(halves(cover, 0, 2), camera, size);
    const auto whole = std::ranges::count(all, GetParam());
    if (everywhere) {
      EXPECT_EQ(whole, static_cast<std::ptrdiff_t>(all.size())) << "holes";
    }
    EXPECT_GT(whole, static_cast<std::ptrdiff_t>(all.size() / 10));
    for (uint32_t bit = 0; bit < 6; ++bit) {
      const std::vector<uint32_t> some = covered(halves(cover, bit, 0), camera, size);
      const std::vector<uint32_t> others = covered(halves(cover, bit, 1), camera, size);
      size_t twice = 0, never = 0;
      for (size_t i = 0; i < some.size(); ++i) {
        twice += some[i] + others[i] > all[i];
        never += some[i] + others[i] < all[i];
      }
      EXPECT_LE(twice, folds);
      EXPECT_EQ(never, 0u);
    }
  }
};

// MsaaTest checks the sample counts in between in closed form.
INSTANTIATE_TEST_SUITE_P(Samples, ComputeCoverage, testing::Values(1, 4, 16),
                         [](const auto& info) { return std::to_string(info.param); });

TEST_P(ComputeCoverage, MeshesCoverEachSampleOnce) {
  // From triangles of 200 pixels to triangles of a tenth of a pixel. None may be so thin that it folds over when its
  // vertices are snapped.
  for (const uint32_t cells : {1u, 3u, 20u, 111u, 700u}) {
    SCOPED_TRACE(fmt::format("{} x {} cells", cells, cells));
    expectCoveredOnce(randomGrid(cells, cells, cells > 100 ? 0.2f : 0.45f), frontCamera(0.97f), 128);
  }
}

TEST_P(ComputeCoverage, FansCoverEachSampleOnce) {
  for (const uint32_t slices : {4u, 60u, 2000u}) {
    SCOPED_TRACE(fmt::format("{} slices", slices));
    expectCoveredOnce(fan(slices, slices), frontCamera(0.97f), 200);
  }
}

// A floor that the camera stands on and looks along: triangles pass next to the camera and behind it, and every row of
// triangles crosses the near plane somewhere. The reference is a grid of a single cell, whose only edges are the
// floor's rim and one diagonal.
TEST_P(ComputeCoverage, TheNearPlaneOpensNoHoles) {
  constexpr uint32_t kSide = 96;
  for (const float height : {0.05f, 0.001f})
    for (const float down : {0.0f, 0.3f, 1.2f}) {
      scene::Camera camera = frontPerspective(1.5f, height);
      const float angle = glm::half_pi<float>() - down, c = std::cos(angle), s = std::sin(angle);
      camera.toWorld = camera.toWorld * glm::dmat4(1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, 0, 1);
      camera.nearClip = std::min(2e-3f, 0.3f * height);
      const std::vector<uint32_t> whole = covered(halves(randomGrid(1, 0), 0, 2), camera, kSide);
      for (const uint32_t cells : {7u, 90u}) {
        SCOPED_TRACE(fmt::format("{} m above {} x {} cells, {} down", height, cells, cells, down));
        // Distant triangles are so thin that some fold over.
        const size_t folds = GetParam() > 1 ? 8 : 0;
        expectCoveredOnce(randomGrid(cells, 40 + cells), camera, kSide, false, folds);
        EXPECT_EQ(covered(halves(randomGrid(cells, 40 + cells), 0, 2), camera, kSide), whole);
      }
    }
}

// Triangles of 10,000 pixels and more, most of which are outside the image.
TEST_P(ComputeCoverage, HugeTrianglesCoverEachSampleOnce) {
  for (const float half : {1e-2f, 1e-4f}) {
    SCOPED_TRACE(half);
    expectCoveredOnce(randomGrid(3, 9), frontCamera(half), 96);
    expectCoveredOnce(fan(100, 11), frontCamera(half), 96);
  }
}

// --- against closed forms -------------------------------------------------------------------------------------------

// Coordinates in units of 1/256 pixel; a pixel is 1/16 units wide.
using Corner = glm::ivec2;
constexpr uint32_t kClosedSide = 64;

scene::Scene triangleOf(const std::array<Corner, 3>& corners) {
  Cover cover{{}, {0, 1, 2}};
  for (const Corner c : corners) cover.points.push_back(vec2(c.x - 8192, 8192 - c.y) / 4096.0f);
  return halves(cover, 0, 2);
}

// Counts the samples inside a triangle in integers. A sample on an edge belongs to the triangle whose top or left edge
// it is.
uint32_t samplesInside(std::array<Corner, 3> t, Corner pixel, uint32_t samples) {
  const auto cross = [](Corner u, Corner v) { return int64_t{u.x} * v.y - int64_t{u.y} * v.x; };
  if (cross(t[1] - t[0], t[2] - t[0]) < 0) std::swap(t[1], t[2]);  // clockwise, y down
  uint32_t inside = 0;
  for (uint32_t s = 0; s < samples; ++s) {
    const shared::vec2 place = shared::samplePlace(samples, s) * 256.0f;
    const Corner at = pixel * 256 + Corner(place);
    bool in = true;
    for (int i = 0; i < 3; ++i) {
      const Corner way = t[(i + 1) % 3] - t[i];
      const int64_t side = cross(way, at - t[i]);
      in = in && (side > 0 || (side == 0 && (way.y < 0 || (way.y == 0 && way.x > 0))));
    }
    inside += in;
  }
  return inside;
}

// Random triangles of every size, some with vertices exactly at sample positions. Each pixel has exactly the samples
// that exact arithmetic counts, and their sum approaches the area as the sample count grows.
TEST_P(ComputeCoverage, ATriangleCoversTheSamplesThatExactArithmeticCounts) {
  std::mt19937 random(5);
  double off = 0;
  for (int triangle = 0; triangle < 60; ++triangle) {
    const int reach = 200 << triangle % 7;  // in subpixels
    const int grid = triangle % 2 ? 1 : 16;
    std::uniform_int_distribution<int> middle(0, 64 * 256), aside(-reach, reach);
    const Corner center(middle(random), middle(random));
    std::array<Corner, 3> corners;
    for (Corner& c : corners) c = (center + Corner(aside(random), aside(random))) / grid * grid;
    const std::vector<uint32_t> found = covered(triangleOf(corners), frontCamera(2), kClosedSide);
    size_t wrong = 0, total = 0;
    for (uint32_t i = 0; i < found.size(); ++i) {
      wrong += found[i] != samplesInside(corners, Corner(i % kClosedSide, i / kClosedSide), GetParam());
      total += found[i];
    }
    EXPECT_EQ(wrong, 0u) << triangle;
    const bool within = std::ranges::all_of(
        corners, [](Corner c) { return c.x >= 0 && c.y >= 0 && c.x <= 64 * 256 && c.y <= 64 * 256; });
    const Corner u = corners[1] - corners[0], v = corners[2] - corners[0];
    const double area = std::abs(double(u.x) * v.y - double(u.y) * v.x) / 2 / 65536;
    const double perimeter = (glm::length(vec2(u)) + glm::length(vec2(v)) + glm::length(vec2(v - u))) / 256;
    if (within) off = std::max(off, std::abs(static_cast<double>(total) / GetParam() - area) / (1 + perimeter));
  }
  fmt::print("{} samples: areas at most {:.4f} of a pixel off for each pixel of the rim\n", GetParam(), off);
  EXPECT_LT(off, 0.5 / std::sqrt(GetParam()));
}

// --- against the graphics pipeline ----------------------------------------------------------------------------------

struct Difference {
  size_t pixels = 0, ids = 0;     // ids: number of pixels that differ
  double depths = 0, albedo = 0;  // largest difference where ids are equal; depth relative
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
      if (glm::dot(a, b) < 0.999f) continue;  // another triangle of the same object
      const double near = imageOf(compute, Aov::Depth).values[i], far = imageOf(hardware, Aov::Depth).values[i];
      d.depths = std::max(d.depths, std::abs(near - far) / far);
      const vec3 albedo = vec3At(imageOf(compute, Aov::Albedo), i) - vec3At(imageOf(hardware, Aov::Albedo), i);
      d.albedo = std::max(d.albedo, double{std::abs(albedo.x)});
    }
    return d;
  }
};

// The graphics pipeline rounds differently, so pixels whose centers lie on an edge, within 1/256 px, may differ.
TEST_F(AgainstHardware, TheSameSurfacesAreVisible) {
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

// With four samples as well. For partly covered pixels, the graphics pipeline evaluates the material at a different
// point of the pixel, which is visible in highlights and textures. On a CPU device its glass has one sample, so the
// rims differ.
TEST_F(AgainstHardware, TheSameImageWithFourSamples) {
  const auto pixelsOff = [](const scene::Scene& scene, uint32_t width, uint32_t height) {
    const scene::Environment environment = constantEnvironment();
    const scene::Camera camera = cameraOf(scene, width, height);
    Settings settings = computeSettings(width, height, {});
    settings.display = true;
    settings.aa.samples = 4;
    Renderer renderer(device(), scene, scene.lights.empty() ? &environment : nullptr);
    const std::vector<uint8_t> compute = std::move(renderer.render({&camera, 1}, settings).front().display);
    settings.raster = Raster::Hardware;
    const std::vector<uint8_t> hardware = std::move(renderer.render({&camera, 1}, settings).front().display);
    size_t off = 0;
    for (size_t i = 0; i < compute.size(); i += 4) {
      int worst = 0;
      for (size_t c = i; c < i + 4; ++c) worst = std::max(worst, std::abs(compute[c] - hardware[c]));
      off += worst > 16;
    }
    return static_cast<double>(off) / (width * height);
  };
  std::vector<std::string> paths;
  for (const char* model : {"textured.glb", "intricate.glb"}) paths.push_back(models::modelPath(model).string());
  paths.push_back("builtin:hall,triangles=60k,lights=20,glass=1");
  for (const std::string& model : models::withReal({}, {"DamagedHelmet.glb"}))
    paths.push_back(models::modelPath(model).string());
  for (const std::string& path : paths) {
    const double share = pixelsOff(scene::load(path), 150, 100);
    fmt::print("{}: {:.2f} % of the pixels differ by more than 16 levels\n", path, 100 * share);
    EXPECT_LT(share, 0.02) << path;
  }
}

TEST_F(AgainstHardware, BlendedSurfacesAsOpaqueOnes) {
  const scene::Scene scene = scene::load(models::modelPath("blended.glb").string());
  const Difference d = compare(scene, cameraOf(scene, 200, 150), 200, 150, DataSurfaces::Any);
  EXPECT_LE(d.ids, d.pixels / 500);
}

// At exactly equal depth, the surface that is drawn last is visible. The order is by material, mesh, then instance
// index.
TEST_F(AgainstHardware, AtEqualDepthTheLastOneIsVisible) {
  scene::SceneBuilder builder("same");
  builder.scene.meshes = {squareMesh(), squareMesh()};
  for (const float red : {0.2f, 0.6f, 0.9f})
    builder.scene.materials.push_back(scene::plainMaterial(fmt::format("{}", red), vec3(red, 0, 0), 0, 1));
  const std::pair<uint32_t, uint32_t> kinds[] = {{1, 2}, {0, 1}, {1, 1}, {0, 0}, {0, 2}, {1, 0}};
  for (const auto& [mesh, material] : kinds) builder.addInstance("square", builder.kRoot, mesh, material, glm::mat4(1));
  const Difference d = compare(builder.scene, frontCamera(0.9f), 64, 64);
  EXPECT_EQ(d.ids, 0u);
  EXPECT_LT(d.albedo, 1e-6);
}

// --- the same in every run, at once and one by one ------------------------------------------------------------------

class ComputeRuns : public ComputeCoverage {};
INSTANTIATE_TEST_SUITE_P(Samples, ComputeRuns, testing::Values(1, 16),
                         [](const auto& info) { return std::to_string(info.param); });

TEST_P(ComputeRuns, EveryRunReturnsTheSameBytes) {
  Settings settings = computeSettings(200, 120, {Aov::Depth, Aov::Part, Aov::Normal, Aov::Color, Aov::Motion});
  settings.shadows = ShadowFormat::D32;
  settings.aa.samples = GetParam();
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

TEST_P(ComputeRuns, ViewsOfABatchEqualSingleViews) {
  std::vector<scene::Camera> cameras(5, cameraOf(hall(), 96, 64));
  for (size_t i = 0; i < cameras.size(); ++i) {
    const float angle = 1.3f * static_cast<float>(i), c = std::cos(angle), s = std::sin(angle);
    cameras[i].toWorld = cameras[i].toWorld * glm::dmat4(c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  }
  Settings settings = computeSettings(96, 64, {Aov::Depth, Aov::Part, Aov::Albedo, Aov::Color, Aov::Samples});
  settings.aa.samples = GetParam();
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

// Queues that are too small at first: the frame is rendered again and is complete.
TEST_P(ComputeRuns, OverflowingQueuesGrowAndTheFrameRepeats) {
  const std::vector<uint32_t> all = covered(halves(fan(20000, 3), 0, 2), frontCamera(0.97f), 512);
  EXPECT_EQ(std::ranges::count(all, GetParam()), 512 * 512);
}

}  // namespace
}  // namespace latelight::render::test
