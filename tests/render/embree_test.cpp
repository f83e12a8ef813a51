// Depth, distance, position, normals, uv and part at every pixel center, against an independent CPU ray caster.
//
// An *edge pixel* is one where the rasterizer may correctly select another triangle than the ray does:
//   edge  the pixel's center lies within 1/256 px of the projection of a triangle's edge that is not occluded (its
//         depth is at most 0.1 % beyond what is visible on either side). A device with 8 sub-pixel bits moves edges by
//         up to half the diagonal of a cell, 0.0028 px; the rest of the 0.0039 px is for rounding in float32.
//   tie   two surfaces lie within the tolerance of depth of each other along the ray
//   mask  an alpha mask differs at one of four points 1/256 px from the center
// Any other difference fails the test. Parts may differ at up to 0.1 % of the pixels with a visible surface.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "models/models.h"
#include "render/reference_caster.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using output::Aov;

constexpr uint32_t kWidth = 640, kHeight = 360;
constexpr double kDepthTolerance = 1e-4;  // relative
constexpr double kMaxEdgeParts = 1e-3;
// Tolerance of interpolated attributes; if they change quickly, in units of their change per pixel. The CPU device
// stores attributes as planes over the image in float32, so the error is 6e-8 after a cancellation of up to a thousand
// pixels.
constexpr double kInterpolation = 2e-4;

struct Worst {
  double value = 0;
  void add(double v) { value = std::max(value, std::isnan(v) ? std::numeric_limits<double>::infinity() : v); }
};

struct Report {
  size_t covered = 0, edges = 0, parts = 0, other = 0, unexplained = 0;
  Worst depth, distance, position, geonormal, normal, uv;
  std::string first;  // description of the first unexplained pixel

  void merge(const Report& r) {
    covered += r.covered, edges += r.edges, parts += r.parts, other += r.other, unexplained += r.unexplained;
    depth.add(r.depth.value), distance.add(r.distance.value), position.add(r.position.value);
    geonormal.add(r.geonormal.value), normal.add(r.normal.value), uv.add(r.uv.value);
    if (first.empty()) first = r.first;
  }
};

// The differences at one pixel, as multiples of the tolerance, except `part`.
struct Difference {
  bool part = false;
  double depth = 0, distance = 0, position = 0, geonormal = 0, normal = 0, uv = 0;
  double largest() const { return std::max({depth, distance, position, geonormal, normal, uv}); }
};

class Comparison {
 public:
  Comparison(vk::Device& device, const scene::Scene& scene, const scene::Camera& camera)
      : scene_(scene), caster_(scene, camera, kWidth, kHeight) {
    Settings settings = settingsOf(
        kWidth, kHeight, {Aov::Depth, Aov::Distance, Aov::Position, Aov::GeoNormal, Aov::Normal, Aov::Uv, Aov::Part});
    settings.axes = Axes::ZUp;
    frame_ = renderOne(device, scene, camera, settings);
  }

  Report run() const {
    std::vector<Report> rows(kHeight);
    parallelFor(kHeight, 8, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) compare(x, static_cast<uint32_t>(y), rows[y]);
    });
    Report all;
    for (const Report& row : rows) all.merge(row);
    return all;
  }

 private:
  void compare(uint32_t x, uint32_t y, Report& report) const {
    const size_t pixel = size_t{y} * kWidth + x;
    const dvec2 center(x + 0.5, y + 0.5);
    const std::optional<Hit> hit = caster_.cast(center);
    const uint32_t part = imageOf(frame_, Aov::Part).ids[pixel];
    if (!hit && part == 0) {
      if (!backgroundEverywhere(pixel)) report.unexplained++, report.first = fmt::format("background at {} {}", x, y);
      return;
    }
    ++report.covered;
    const double seen = std::max(hit ? hit->depth : 0.0, double(imageOf(frame_, Aov::Depth).values[pixel]));
    const bool atEdge = caster_.edgeDepth(pixel) <= (std::isinf(seen) ? hit->depth : seen) * 1.001;
    report.edges += atEdge;

    Difference d;
    d.part = (hit ? hit->part : 0) != part;
    if (!d.part) d = difference(*hit, pixel);
    if (d.part || d.largest() > 1) {
      (d.part ? report.parts : report.other)++;
      if (atEdge || tie(center, hit) || maskEdge(center, hit)) return;
      if (report.unexplained++ == 0) report.first = describe(x, y, hit, part, d);
      return;
    }
    report.depth.add(d.depth * kDepthTolerance), report.distance.add(d.distance * kDepthTolerance);
    report.position.add(d.position * kDepthTolerance), report.geonormal.add(d.geonormal);
    report.normal.add(d.normal), report.uv.add(d.uv);
  }

  Difference difference(const Hit& hit, size_t pixel) const {
    const auto relative = [](double value, double expected) { return std::abs(value - expected) / expected; };
    Difference d;
    d.depth = relative(imageOf(frame_, Aov::Depth).values[pixel], hit.depth) / kDepthTolerance;
    d.distance = relative(imageOf(frame_, Aov::Distance).values[pixel], hit.distance) / kDepthTolerance;
    d.position = glm::length(dvec3(vec3At(imageOf(frame_, Aov::Position), pixel)) - hit.position) / hit.distance /
                 kDepthTolerance;
    // A triangle's normal computed from float32 vertices is accurate to 6e-8 divided by the flatness; a few operations
    // follow.
    d.geonormal = glm::length(dvec3(vec3At(imageOf(frame_, Aov::GeoNormal), pixel)) - hit.geonormal) /
                  (2e-6 + 2e-6 / hit.flatness);
    const scene::Instance& instance = scene_.instances[hit.instance];
    const bool mapped = scene_.materials[instance.material].data.textures & (1u << shared::kTextureNormal);
    if (!mapped)
      d.normal = glm::length(dvec3(vec3At(imageOf(frame_, Aov::Normal), pixel)) - hit.normal) /
                 (kInterpolation * std::max(1.0, hit.normalPerPixel));
    d.uv = glm::length(dvec2(vec2At(imageOf(frame_, Aov::Uv), pixel)) - hit.uv) /
           (kInterpolation * std::max({1.0, glm::length(hit.uv), hit.uvPerPixel}));
    return d;
  }

  bool backgroundEverywhere(size_t pixel) const {
    return std::isinf(imageOf(frame_, Aov::Depth).values[pixel]) &&
           std::isinf(imageOf(frame_, Aov::Distance).values[pixel]) &&
           vec3At(imageOf(frame_, Aov::Position), pixel) == glm::vec3(0) &&
           vec3At(imageOf(frame_, Aov::Normal), pixel) == glm::vec3(0) &&
           vec3At(imageOf(frame_, Aov::GeoNormal), pixel) == glm::vec3(0) &&
           vec2At(imageOf(frame_, Aov::Uv), pixel) == glm::vec2(0);
  }

  bool tie(dvec2 center, const std::optional<Hit>& hit) const {
    return hit && caster_.surfacesNear(center, hit->depth, kDepthTolerance) > 1;
  }

  bool maskEdge(dvec2 center, const std::optional<Hit>& hit) const {
    constexpr double r = ReferenceCaster::kEdgeReach;
    for (dvec2 offset : {dvec2(r, 0), dvec2(-r, 0), dvec2(0, r), dvec2(0, -r)}) {
      const std::optional<Hit> neighbor = caster_.cast(center + offset);
      if ((neighbor ? neighbor->part : 0) != (hit ? hit->part : 0)) return true;
    }
    return false;
  }

  std::string describe(uint32_t x, uint32_t y, const std::optional<Hit>& hit, uint32_t part,
                       const Difference& d) const {
    return fmt::format(
        "pixel {} {}: part {} where the caster sees {}; depth {} against {}; times the tolerance: depth {:.3g}, "
        "distance "
        "{:.3g}, position {:.3g}, geonormal {:.3g}, normal {:.3g}, uv {:.3g}",
        x, y, part, hit ? hit->part : 0, imageOf(frame_, Aov::Depth).values[size_t{y} * kWidth + x],
        hit ? hit->depth : 0, d.depth, d.distance, d.position, d.geonormal, d.normal, d.uv);
  }

  const scene::Scene& scene_;
  ReferenceCaster caster_;
  output::FrameOutput frame_;
};

class EmbreeTest : public RenderTest {
 protected:
  // `minCover` is the fraction of the image that must be covered, so that an empty image fails.
  static void compare(const std::string& name, const scene::Scene& scene, const scene::Camera& camera,
                      double minCover) {
    const Report r = Comparison(device(), scene, camera).run();
    const double covered = static_cast<double>(r.covered);
    fmt::print(
        "{}: {} pixels covered; edge pixels {:.4f} %, parts differ at {:.4f} %, other values at {:.4f} %; elsewhere "
        "the "
        "most are: depth {:.2e}, distance {:.2e}, position {:.2e} (relative), normal {:.2f}, geonormal {:.2f} and uv "
        "{:.2f} of their tolerance\n",
        name, r.covered, 100 * r.edges / covered, 100 * r.parts / covered, 100 * r.other / covered, r.depth.value,
        r.distance.value, r.position.value, r.normal.value, r.geonormal.value, r.uv.value);
    EXPECT_GT(covered, minCover * kWidth * kHeight);
    EXPECT_EQ(r.unexplained, 0u) << r.first;
    EXPECT_LT(r.parts, kMaxEdgeParts * covered);
  }

  static void compareFile(const std::filesystem::path& path, double minCover) {
    const scene::Scene scene = scene::load(path);
    compare(path.filename(), scene, cameraOf(scene, kWidth, kHeight), minCover);
  }
};

TEST_F(EmbreeTest, Models) {
  for (const char* name : {"skinned.glb", "morphed.glb", "punctual.glb", "many_materials.glb"})
    compareFile(models::modelPath(name), 0.05);
  for (const std::string& name : models::withReal({}, {"DamagedHelmet.glb", "Fox.glb", "CesiumMan.glb"}))
    compareFile(models::modelPath(name), name == "DamagedHelmet.glb" ? 0.2 : 0.05);
}

TEST_F(EmbreeTest, TwoCylinderEngine) {
  const std::filesystem::path path = "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "Debian's assimp-testmodels is not installed";
  compareFile(path, 0.1);
}

TEST_F(EmbreeTest, Spheres) {
  compareFile("builtin:spheres", 0.15);
}
TEST_F(EmbreeTest, Boxes) {
  compareFile("builtin:boxes", 0.9);
}
TEST_F(EmbreeTest, Hall) {
  compare("hall", hall(), cameraOf(hall(), kWidth, kHeight), 0.9);
}

// Squares rotated about the vertical axis: single- and double-sided, mirrored, and alpha-masked with texels so large
// that the texture's mip level 0 is sampled.
scene::Scene turnedSquares() {
  scene::SceneBuilder builder("squares");
  scene::Scene& scene = builder.scene;
  addSquareOfFourKinds(scene);
  for (uint32_t i = 0; i < 32; ++i) {
    const float angle = 0.35f + 0.77f * static_cast<float>(i), mirror = i & 4 ? -1.3f : 0.8f;
    glm::mat4 local(1);
    local[0] = glm::vec4(mirror * std::cos(angle), 0.2f, -std::sin(angle), 0);
    local[1] = glm::vec4(0.1f, 1.1f, 0.3f, 0);
    local[2] = glm::vec4(std::sin(angle), 0, std::cos(angle), 0);
    local[3] = glm::vec4(-7 + 2 * static_cast<float>(i % 8), 3.6f - 2.4f * static_cast<float>(i / 8),
                         -0.1f * static_cast<float>(i), 1);
    builder.addInstance("square", builder.kRoot, 0, i % 4, local);
  }
  return std::move(builder.scene);
}

TEST_F(EmbreeTest, TurnedMirroredAndMaskedSquares) {
  const scene::Scene scene = turnedSquares();
  compare("squares", scene, frontPerspective(0.6f, 16), 0.1);
}

TEST_F(EmbreeTest, OrthographicAndOffCenter) {
  const scene::Scene scene = turnedSquares();
  compare("orthographic squares", scene, frontCamera(5, 20), 0.1);
  scene::Camera shifted = frontPerspective(0.6f, 16);
  shifted.principal = {0.3f, -0.2f};
  compare("off-center squares", scene, shifted, 0.05);
}

// The camera stands between the boxes: triangles are behind it, cross its near plane and are larger than the image.
TEST_F(EmbreeTest, InsideALargeTriangle) {
  const scene::Scene scene = scene::load("builtin:boxes");
  scene::Camera camera = scene.cameras.front();
  camera.toWorld[3] = glm::vec4(-0.25f, -1.25f, 0.3f, 1);  // just above the floor, between the boxes
  camera.nearClip = 0.01f;
  camera.verticalFov = 2.0f;
  compare("between the boxes", scene, camera, 0.5);
}

}  // namespace
}  // namespace latelight::render::test
