// Renderer::cast(): along the rays of pixels it returns the raster's values, and in any direction those of an
// independent ray caster in double precision. Rays through edges and vertices of closed meshes hit them.
#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "models/models.h"
#include "rays/slivers.h"
#include "render/rays/triangle_boxes.h"
#include "render/reference_caster.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "scene/scene_builder.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using output::Aov;

constexpr uint32_t kWidth = 160, kHeight = 90;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Settings castSettings() {
  Settings settings = settingsOf(kWidth, kHeight,
                                 {Aov::Depth, Aov::Distance, Aov::Position, Aov::GeoNormal, Aov::Normal, Aov::Uv,
                                  Aov::Id, Aov::Part, Aov::Material});
  settings.axes = Axes::ZUp;
  return settings;
}

struct PixelRays {
  std::vector<dvec3> origins, directions;
};

// The rays of all pixels of a camera, in the renderer's world. The direction's component along the view axis is 1.
PixelRays pixelRays(const scene::Camera& camera) {
  PixelRays rays;
  const double up = camera.orthographic ? double{camera.yHalf} : std::tan(0.5 * double{camera.verticalFov});
  const dvec2 scale(up * kWidth / kHeight, up);
  glm::dmat3 axes(camera.toWorld);
  for (int i = 0; i < 3; ++i) axes[i] = glm::normalize(axes[i]);
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const dvec2 ndc(2 * (x + 0.5) / kWidth - 1 - double{camera.principal.x},
                      1 - 2 * (y + 0.5) / kHeight - double{camera.principal.y});
      const dvec3 across = axes[0] * (ndc.x * scale.x) + axes[2] * (ndc.y * scale.y);
      const dvec3 eye(camera.toWorld[3]);
      rays.origins.push_back(camera.orthographic ? eye + across : eye);
      rays.directions.push_back(camera.orthographic ? axes[1] : axes[1] + across);
    }
  return rays;
}

struct Largest {
  double value = 0;
  void add(double v) { value = std::max(value, std::isnan(v) ? double{kInfinity} : v); }
};

class CastTest : public RenderTest {
 protected:
  static CastHits cast(const scene::Scene& scene, const std::vector<dvec3>& origins,
                       const std::vector<dvec3>& directions) {
    Renderer renderer(device(), scene, nullptr);
    return renderer.cast({origins, directions}, castSettings()).hits;
  }

  // Compares with Embree, refined in double precision, and with the raster's ids, at pixels off edges.
  static void compare(const std::string& name, const scene::Scene& scene, const scene::Camera& camera) {
    Renderer renderer(device(), scene, nullptr);
    const Settings settings = castSettings();
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
    const PixelRays rays = pixelRays(camera);
    const CastHits hits = renderer.cast({rays.origins, rays.directions}, settings).hits;
    const ReferenceCaster reference(scene, camera, kWidth, kHeight);
    size_t covered = 0, edges = 0, wrong = 0;
    Largest distance, position, geonormal, uv, raster;
    std::string first;
    for (size_t i = 0; i < hits.distance.size(); ++i) {
      const std::optional<Hit> hit = reference.cast(dvec2(i % kWidth + 0.5, i / kWidth + 0.5));
      if (!hit && hits.part[i] == 0) {
        EXPECT_EQ(hits.distance[i], kInfinity);
        continue;
      }
      ++covered;
      const bool atEdge = reference.edgeDepth(i) <= (hit ? hit->depth : double{kInfinity}) * 1.001;
      const dvec2 center(i % kWidth + 0.5, i / kWidth + 0.5);
      if (atEdge || (hit && reference.surfacesNear(center, hit->depth, 1e-5) > 1)) {
        ++edges;
        continue;
      }
      if (!hit || hits.part[i] != hit->part || hits.triangle[i] != hit->triangle) {
        if (wrong++ == 0)
          first = fmt::format("pixel {} {}: part {} triangle {} at {}, but the caster hits part {} triangle {} at {}",
                              i % kWidth, i / kWidth, hits.part[i], hits.triangle[i], hits.distance[i],
                              hit ? hit->part : 0, hit ? hit->triangle : 0, hit ? hit->distance : 0);
        continue;
      }
      distance.add(std::abs(hits.distance[i] - hit->distance) / hit->distance);
      position.add(glm::length(dvec3(hits.position[i]) - hit->position) / hit->distance);
      geonormal.add(glm::length(dvec3(hits.geonormal[i]) - hit->geonormal) / (2e-6 + 2e-6 / hit->flatness));
      uv.add(glm::length(dvec2(hits.uv[i]) - hit->uv) /
             (2e-4 * std::max({1.0, glm::length(hit->uv), hit->uvPerPixel})));
      if (imageOf(frame, Aov::Part).ids[i] != hits.part[i]) continue;  // the raster's own tests check this
      EXPECT_EQ(imageOf(frame, Aov::Id).ids[i], hits.id[i]);
      EXPECT_EQ(imageOf(frame, Aov::Material).ids[i], hits.material[i]);
      raster.add(std::abs(hits.distance[i] - double{imageOf(frame, Aov::Distance).values[i]}) / hit->distance);
    }
    fmt::print(
        "{}: {} pixels hit, {} at edges, {} wrong; distance {:.1e}, position {:.1e}, against the raster {:.1e}; "
        "geonormal {:.2f} and uv {:.2f} of their tolerance\n",
        name, covered, edges, wrong, distance.value, position.value, raster.value, geonormal.value, uv.value);
    EXPECT_GT(covered - edges, 0.04 * kWidth * kHeight);
    EXPECT_EQ(wrong, 0u) << first;
    // The caster's vertices are morphed by the host; devices may fuse the products of weights into the sum.
    const double tolerance = name == "morphed.glb" ? 2e-6 : 1e-6;
    EXPECT_LT(distance.value, tolerance);
    EXPECT_LT(position.value, tolerance);
    EXPECT_LT(geonormal.value, 1);
    EXPECT_LT(uv.value, 1);
  }

  static void compareFile(const std::filesystem::path& path) {
    const scene::Scene scene = scene::load(path);
    compare(path.filename(), scene, cameraOf(scene, kWidth, kHeight));
  }
};

TEST_F(CastTest, HitsTheSurfacesThatEmbreeHits) {
  for (const char* name : {"skinned.glb", "morphed.glb", "punctual.glb", "many_materials.glb"})
    compareFile(models::modelPath(name));
  for (const std::string& name : models::withReal({}, {"DamagedHelmet.glb", "Fox.glb", "CesiumMan.glb"}))
    compareFile(models::modelPath(name));
  compareFile("builtin:spheres");
  compareFile("builtin:boxes");
  compare("hall", hall(), cameraOf(hall(), kWidth, kHeight));
}

// Squares rotated about the vertical axis: single- and double-sided, mirrored, and alpha-masked with texels so large
// that the raster samples mip level 0 of the texture.
scene::Scene turnedSquares(double farAway = 0) {
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
  for (scene::Instance& instance : scene.instances) instance.toWorld[3].x += farAway;
  return std::move(builder.scene);
}

TEST_F(CastTest, HitsSidesMirrorsAndMasksAsTheRaster) {
  compare("squares", turnedSquares(), frontPerspective(0.6f, 16));
  compare("orthographic squares", turnedSquares(), frontCamera(5, 20));
}

scene::Scene oneMesh(scene::Mesh mesh, bool doubleSided) {
  scene::SceneBuilder builder("mesh");
  builder.scene.meshes.push_back(std::move(mesh));
  scene::findBounds(builder.scene.meshes.back());
  scene::Material material;
  material.data.baseColor = glm::vec4(1);
  material.data.id = 7;
  material.data.flags = doubleSided ? shared::kMaterialDoubleSided : 0u;
  builder.scene.materials.push_back(material);
  builder.addInstance("mesh", builder.kRoot, 0, 0, glm::mat4(1));
  builder.scene.instances[0].toWorld = glm::dmat4(1);
  return std::move(builder.scene);
}

constexpr size_t kFar = 6'400'000;  // meters, from a planet's center to its surface

// The same squares a planet's radius from the origin, whose floats have steps of half a meter there.
TEST_F(CastTest, IsAsPreciseFarFromTheOrigin) {
  const scene::Scene near = turnedSquares(), far = turnedSquares(double{kFar});
  PixelRays rays = pixelRays(frontPerspective(0.6f, 16));
  const CastHits expected = cast(near, rays.origins, rays.directions);
  for (dvec3& origin : rays.origins) origin.x += double{kFar};
  const CastHits hits = cast(far, rays.origins, rays.directions);
  size_t hitCount = 0;
  for (size_t i = 0; i < hits.distance.size(); ++i) {
    if (std::isinf(expected.distance[i]) || std::isinf(hits.distance[i])) continue;
    ++hitCount;
    if (hits.triangle[i] == expected.triangle[i] && hits.normal[i] == expected.normal[i]) {
      EXPECT_NEAR(hits.distance[i], expected.distance[i], 2e-6 * expected.distance[i]);
    }
  }
  EXPECT_GT(hitCount, 1000u);
}

// From the center of a closed mesh, a ray to each vertex and to the center of each edge hits the mesh: no ray passes
// between two triangles.
TEST_F(CastTest, NoRayPassesBetweenTriangles) {
  const scene::Mesh sphere = sphereMesh(2);
  std::vector<dvec3> origins, directions;
  const dvec3 inside(0.31, -0.17, 0.23);
  const auto add = [&](dvec3 target) {
    for (const dvec3& from : {dvec3(0), inside}) origins.push_back(from), directions.push_back(target - from);
  };
  for (size_t i = 0; i < sphere.indices.size(); ++i) {
    const dvec3 a(sphere.positions[sphere.indices[i]]);
    const dvec3 b(sphere.positions[sphere.indices[i - i % 3 + (i % 3 + 1) % 3]]);
    add(a);
    for (const double share : {0.5, 0.25, 0.123456789}) add(glm::mix(a, b, share));
  }
  const CastHits hits = cast(oneMesh(sphere, true), origins, directions);
  size_t leaks = 0;
  for (size_t i = 0; i < hits.distance.size(); ++i) {
    leaks += std::isinf(hits.distance[i]);
    const double length = glm::length(directions[i]);
    if (!std::isinf(hits.distance[i])) {
      EXPECT_NEAR(hits.distance[i], length, 1e-5 * length);
    }
  }
  EXPECT_GT(hits.distance.size(), 4000u);
  EXPECT_EQ(leaks, 0u);
}

// The boxes of its triangles are divided, at planes where halves, quarters, eighths ... of the mesh end.
TEST_F(CastTest, NoRayPassesBetweenPartsOfTriangles) {
  const scene::Mesh tube = sliverTube(64, 20);
  EXPECT_FALSE(triangleBoxes(tube).triangles.empty());
  const scene::Scene scene = oneMesh(tube, true);
  compare("slivers", scene, frontPerspective(0.9f, 22));
  const glm::vec3 low = tube.boundsMin, size = tube.boundsMax - low;
  std::vector<dvec3> origins, directions;
  for (size_t i = 0; i < tube.indices.size(); ++i) {
    const dvec3 a(tube.positions[tube.indices[i]]);
    const dvec3 b(tube.positions[tube.indices[i - i % 3 + (i % 3 + 1) % 3]]);
    for (int axis = 0; axis < 3; ++axis)
      for (int part = 1; part < 64; ++part) {
        const double share = (low[axis] + size[axis] * part / 64.0 - a[axis]) / (b[axis] - a[axis]);
        if (!(share > 0 && share < 1)) continue;
        origins.emplace_back(0);
        directions.push_back(glm::mix(a, b, share));
      }
  }
  const CastHits hits = cast(scene, origins, directions);
  size_t leaks = 0;
  for (const float distance : hits.distance) leaks += std::isinf(distance);
  EXPECT_GT(hits.distance.size(), 4000u);
  EXPECT_EQ(leaks, 0u);
}

scene::Mesh cubeMesh() {  // [-1, 1]^3
  scene::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    mesh.attributes.push_back({glm::normalize(mesh.positions.back()), glm::vec4(1, 0, 0, 1), glm::vec2(0)});
  }
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

// A cube along its axes: from inside, along its edges just inside and just outside, and through its corners.
TEST_F(CastTest, HitsAlongAxesAndEdges) {
  constexpr double kLittle = 0x1p-20;
  std::vector<dvec3> origins, directions;
  std::vector<float> expected;
  const auto add = [&](dvec3 origin, dvec3 direction, float distance) {
    origins.push_back(origin), directions.push_back(direction), expected.push_back(distance);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      dvec3 along(0), besides(0.5);
      along[axis] = sign, besides[axis] = 0;
      add(dvec3(0), along, 1);
      add(besides - along * 3.0, along, 2);
      for (const double side : {1 - kLittle, 1 + kLittle}) {
        dvec3 edge(side);
        edge[axis] = -3 * sign;
        add(edge, along, side < 1 ? 2 : kInfinity);
      }
    }
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 to(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    add(dvec3(0), to, std::sqrt(3.0f));
  }
  const CastHits hits = cast(oneMesh(cubeMesh(), true), origins, directions);
  for (size_t i = 0; i < origins.size(); ++i)
    if (std::isinf(expected[i]))
      EXPECT_EQ(hits.distance[i], kInfinity) << i;
    else
      EXPECT_NEAR(hits.distance[i], expected[i], 4e-7) << i;
}

// Rays from afar to points of the cube's face x = 1 and next to it. Hits are those of the rays as doubles, whose
// rounding moves the point by some 1e-16 of the distance. Along a direction of floats, it would be 6e-8 of it.
TEST_F(CastTest, IsAsPreciseFromFarAway) {
  scene::Mesh mesh = cubeMesh();
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    mesh.attributes[i].uv0 = (glm::vec2(mesh.positions[i].y, mesh.positions[i].z) + 1.0f) * 0.5f;
  const scene::Scene scene = oneMesh(mesh, false);
  Renderer renderer(device(), scene, nullptr);
  for (const double far : {4.0, 1e3, 1e5, 1e8, 1e11})
    for (const dvec3 direction : {dvec3(-1, 0, 0), glm::normalize(dvec3(-1, 0.3, 0.2))}) {
      SCOPED_TRACE(testing::Message() << far << " m, y " << direction.y);
      const double tolerance = 1e-6 + 5e-16 * far;
      std::vector<dvec3> origins, directions;
      for (int y = -20; y <= 20; ++y)
        for (int z = -20; z <= 20; ++z) {
          origins.push_back(dvec3(1, y * 0.049, z * 0.049) - far * direction);
          directions.push_back(direction);
        }
      const CastHits hits = renderer.cast({origins, directions}, castSettings()).hits;
      Largest position, uv, normal, distance;
      for (size_t i = 0; i < origins.size(); ++i) {
        const double t = (1 - origins[i].x) / direction.x;
        const dvec2 expected(origins[i].y + t * direction.y, origins[i].z + t * direction.z);
        position.add(glm::length(dvec3(hits.position[i]) - dvec3(1, expected)));
        uv.add(glm::length(dvec2(hits.uv[i]) * 2.0 - 1.0 - expected));
        normal.add(glm::length(hits.geonormal[i] - glm::vec3(1, 0, 0)));
        distance.add(std::abs(double{hits.distance[i]} / t - 1));
      }
      EXPECT_LT(position.value, tolerance);
      EXPECT_LT(uv.value, 2 * tolerance);
      EXPECT_EQ(normal.value, 0);
      EXPECT_LT(distance.value, 1.2e-7);
      // The maximum distance is still that from the origin, also between two floats.
      for (const bool reaches : {false, true}) {
        const double end = far + (reaches ? 0.01 : -0.01);
        const std::vector<dvec3> one{dvec3(1, 0.2, 0.1) - far * direction}, along{direction};
        const float found = renderer.cast({one, along, end}, castSettings()).hits.distance[0];
        EXPECT_EQ(std::isfinite(found), reaches) << end;
      }
    }
  const std::vector<dvec3> origins{dvec3(1e8, 1.0001, 0), dvec3(1e8, 0, -1.0001), dvec3(1e8, 0, 0), dvec3(0, 1e300, 0)};
  const std::vector<dvec3> directions{dvec3(-1, 0, 0), dvec3(-1, 0, 0), dvec3(1, 0, 0), dvec3(0, -1, 0)};
  for (const float distance : renderer.cast({origins, directions}, castSettings()).hits.distance)
    EXPECT_EQ(distance, kInfinity);
}

TEST_F(CastTest, OddRaysHitNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const dvec3 along(0, 0, -1);
  const std::vector<dvec3> origins{dvec3(0), dvec3(0), dvec3(nan, 0, 0), dvec3(0), dvec3(0, infinite, 0), dvec3(0)};
  const std::vector<dvec3> directions{dvec3(0), dvec3(0, nan, 0), along, dvec3(infinite, 0, 0), along, 1e-200 * along};
  const CastHits hits = cast(oneMesh(sphereMesh(2), true), origins, directions);
  for (size_t i = 0; i + 1 < origins.size(); ++i) {
    EXPECT_EQ(hits.distance[i], kInfinity) << i;
    EXPECT_EQ(hits.part[i], 0u);
    EXPECT_EQ(hits.normal[i], glm::vec3(0));
  }
  EXPECT_NEAR(hits.distance.back(), 2, 0.05);  // directions may have any length
}

// Materials without a texture have one alpha: below the cutoff, or zero where they are blended, rays pass.
TEST_F(CastTest, TestsTheAlphaOfMaterialsWithoutTextures) {
  struct Case {
    uint32_t flags;
    float alpha;
    bool hits;
  };
  for (const auto& [flags, alpha, expected] :
       {Case{0, 0, true}, Case{shared::kMaterialMasked, 0.5f, true}, Case{shared::kMaterialMasked, 0.49f, false},
        Case{shared::kMaterialBlended, 0, false}, Case{shared::kMaterialBlended, 0.01f, true}}) {
    scene::Scene scene = oneMesh(cubeMesh(), true);
    shared::Material& material = scene.materials[0].data;
    material.flags |= flags;
    material.alphaCutoff = 0.5f;
    material.baseColor.a = alpha;
    Settings settings = castSettings();
    settings.dataSurfaces = DataSurfaces::Any;
    Renderer renderer(device(), scene, nullptr);
    const std::vector<dvec3> origins{dvec3(0.1, 0.2, 5)}, directions{dvec3(0, 0, -1)};
    const CastHits hits = renderer.cast({origins, directions}, settings).hits;
    EXPECT_EQ(hits.distance[0], expected ? 4 : kInfinity) << flags << " " << alpha;
  }
}

// Inside a sphere of single-sided faces, rays pass through the back faces; the maximum distance ends rays.
TEST_F(CastTest, RespectsSidesAndMaximumDistance) {
  const std::vector<dvec3> origins{dvec3(0.01, 0.02, 0), dvec3(0.01, 0.02, 5)};
  const std::vector<dvec3> directions{dvec3(0, 0, -3), dvec3(0, 0, -3)};
  const scene::Scene single = oneMesh(sphereMesh(2), false);
  Renderer renderer(device(), single, nullptr);
  CastHits hits = renderer.cast({origins, directions}, castSettings()).hits;
  EXPECT_EQ(hits.distance[0], kInfinity);
  EXPECT_NEAR(hits.distance[1], 3, 0.05);
  EXPECT_EQ(hits.material[1], 7u);
  EXPECT_GT(hits.geonormal[1].z, 0.9f);
  hits = renderer.cast({origins, directions, 2.5}, castSettings()).hits;
  EXPECT_EQ(hits.distance[1], kInfinity);
  EXPECT_THROW(renderer.cast({origins, std::span(directions).first(1)}, castSettings()), Error);
  EXPECT_THROW(renderer.cast({origins, directions, -1}, castSettings()), Error);
  Settings camera = castSettings();
  camera.normalFrame = NormalFrame::OpenCv;
  EXPECT_THROW(renderer.cast({origins, directions}, camera), Error);
}

// More rays than are in one submission, with some arrays only. Rays with the same origin and direction hit the same.
TEST_F(CastTest, FillsTheArraysThatAreNeeded) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const PixelRays few = pixelRays(cameraOf(scene, kWidth, kHeight));
  PixelRays rays;
  constexpr size_t kCopies = 20;
  for (size_t copy = 0; copy < kCopies; ++copy) {
    rays.origins.insert(rays.origins.end(), few.origins.begin(), few.origins.end());
    rays.directions.insert(rays.directions.end(), few.directions.begin(), few.directions.end());
  }
  Renderer renderer(device(), scene, nullptr);
  const CastHits expected = renderer.cast({few.origins, few.directions}, castSettings()).hits;
  const size_t each = few.origins.size(), count = rays.origins.size();
  ASSERT_GT(count, size_t{1} << 18);
  std::vector<glm::vec3> positions(count), normals(count);
  std::vector<uint32_t> triangles(count);
  renderer.cast({rays.origins, rays.directions},
                CastTargets{.position = positions.data(), .normal = normals.data(), .triangle = triangles.data()},
                castSettings());
  size_t differ = 0;
  for (size_t i = 0; i < count; ++i)
    differ += positions[i] != expected.position[i % each] || normals[i] != expected.normal[i % each] ||
              triangles[i] != expected.triangle[i % each];
  EXPECT_EQ(differ, 0u);
  // Rays of floats are those of doubles with the same values.
  std::vector<glm::vec3> origins(rays.origins.begin(), rays.origins.end()),
      directions(rays.directions.begin(), rays.directions.end());
  const std::vector<dvec3> sameOrigins(origins.begin(), origins.end()),
      sameDirections(directions.begin(), directions.end());
  const CastHits doubles = renderer.cast({sameOrigins, sameDirections}, castSettings()).hits;
  const CastHits floats = renderer.cast({.floatOrigins = origins, .floatDirections = directions}, castSettings()).hits;
  EXPECT_EQ(floats.distance, doubles.distance);
  EXPECT_EQ(floats.position, doubles.position);
  EXPECT_THROW(renderer.cast({.floatOrigins = origins, .floatDirections = {}}, castSettings()), Error);
  renderer.cast({rays.origins, rays.directions}, CastTargets{}, castSettings());
  EXPECT_TRUE(renderer.cast({{}, {}}, castSettings()).hits.distance.empty());
}

// Rays in glTF's frame hit at the same distances, and positions are in the frame of the rays.
TEST_F(CastTest, FollowsAxesAndPositionOrigin) {
  const scene::Scene scene = scene::load(models::modelPath("punctual.glb"));
  ASSERT_TRUE(scene.yUp);
  PixelRays rays = pixelRays(cameraOf(scene, kWidth, kHeight));
  Renderer renderer(device(), scene, nullptr);
  const CastHits expected = renderer.cast({rays.origins, rays.directions}, castSettings()).hits;
  const glm::dmat3 turned(scene::toGltfFromWorld());
  for (size_t i = 0; i < rays.origins.size(); ++i) {
    rays.origins[i] = turned * rays.origins[i];
    rays.directions[i] = turned * rays.directions[i];
  }
  Settings file = castSettings();
  file.axes = Axes::File;
  file.positionOrigin.point = {1, 2, 3};
  const CastHits hits = renderer.cast({rays.origins, rays.directions}, file).hits;
  EXPECT_EQ(hits.distance, expected.distance);
  for (size_t i = 0; i < hits.distance.size(); ++i) {
    if (std::isinf(hits.distance[i])) continue;
    const dvec3 position = turned * dvec3(expected.position[i]) - dvec3(1, 2, 3);
    EXPECT_LT(glm::length(dvec3(hits.position[i]) - position), 1e-5);
    EXPECT_LT(glm::length(dvec3(hits.normal[i]) - turned * dvec3(expected.normal[i])), 1e-6);
  }
}

// Blended surfaces are hit only if data outputs describe them.
TEST_F(CastTest, HitsBlendedSurfacesAsDataOutputsDo) {
  const scene::Scene scene = scene::load(models::modelPath("blended.glb"));
  const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
  const PixelRays rays = pixelRays(camera);
  Renderer renderer(device(), scene, nullptr);
  std::vector<uint32_t> parts[2];
  for (const DataSurfaces surfaces : {DataSurfaces::Opaque, DataSurfaces::Any}) {
    Settings settings = castSettings();
    settings.dataSurfaces = surfaces;
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
    const CastHits hits = renderer.cast({rays.origins, rays.directions}, settings).hits;
    size_t differ = 0;
    for (size_t i = 0; i < hits.part.size(); ++i) differ += hits.part[i] != imageOf(frame, Aov::Part).ids[i];
    EXPECT_LT(differ, 0.004 * kWidth * kHeight);  // at edges
    parts[surfaces == DataSurfaces::Any] = hits.part;
  }
  EXPECT_NE(parts[0], parts[1]);
}

// Compares with the raster's parts and distances in the scene's current state.
void expectAsRaster(Renderer& renderer, const scene::Camera& camera, const SceneState& moment) {
  const PixelRays rays = pixelRays(camera);
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, castSettings(), moment).front());
  const CastHits hits = renderer.cast({rays.origins, rays.directions}, castSettings(), moment).hits;
  size_t differ = 0, covered = 0;
  for (size_t i = 0; i < hits.part.size(); ++i) {
    const double expected = imageOf(frame, Aov::Distance).values[i];
    const bool same = hits.part[i] == imageOf(frame, Aov::Part).ids[i];
    covered += hits.part[i] != 0;
    differ += !same || (!std::isinf(expected) && std::abs(hits.distance[i] - expected) > 1e-4 * expected);
  }
  EXPECT_GT(covered, 0.02 * kWidth * kHeight);
  EXPECT_LT(differ, 0.01 * static_cast<double>(covered));
}

TEST_F(CastTest, FollowsSkinsAndMorphTargets) {
  for (const char* name : {"skinned.glb", "morphed.glb"}) {
    const scene::Scene scene = scene::load(models::modelPath(name));
    const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
    Renderer renderer(device(), scene, nullptr);
    Settings settings = castSettings();
    for (const std::optional<double> time : {std::optional(0.3), std::optional(0.5), std::optional<double>()}) {
      settings.time = time;
      expectAsRaster(renderer, camera, {.poses = posesAt(scene, settings)});
    }
  }
}

TEST_F(CastTest, FollowsEdits) {
  scene::Scene scene = turnedSquares();
  const scene::Camera camera = frontPerspective(0.6f, 16);
  Renderer renderer(device(), scene, nullptr);
  expectAsRaster(renderer, camera, {});
  scene::removeInstance(scene, 3);
  glm::dmat4 moved = scene.instances[5].toWorld;
  moved[3] += glm::dvec4(0.3, 0, 0.4, 0);
  scene::setTransform(scene, 5, moved);
  expectAsRaster(renderer, camera, {});
  scene::setMesh(scene, 0, sphereMesh(0.8f));
  expectAsRaster(renderer, camera, {});
  scene::Material opaque = scene.materials[3];
  opaque.data.flags &= ~shared::kMaterialMasked;
  scene::setMaterial(scene, 3, opaque);
  expectAsRaster(renderer, camera, {});
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (i != 3) scene::removeInstance(scene, i);
  const PixelRays rays = pixelRays(camera);
  EXPECT_EQ(renderer.cast({rays.origins, rays.directions}, castSettings()).hits.part,
            std::vector<uint32_t>(rays.origins.size(), 0));
}

// Each call sees the scene as it was when it was submitted, in whatever order tickets are taken, and also if one of
// them is dropped. The rays are copied.
TEST_F(CastTest, KeepsSeveralCallsInFlight) {
  scene::Scene scene = oneMesh(squareMesh(), false);
  Renderer renderer(device(), scene, nullptr);
  constexpr size_t kCount = 1000;
  std::array<std::vector<float>, 3> distances;
  std::vector<CastTicket> tickets;
  for (int call = 0; call < 3; ++call) {
    glm::dmat4 placed(1);
    placed[3].z = -call;
    scene::setTransform(scene, 0, placed);
    const std::vector<dvec3> origins(kCount, dvec3(0.3, -0.2, 5 + 10 * call)), directions(kCount, dvec3(0, 0, -1));
    distances[call].resize(kCount);
    const CastTargets targets{.distance = distances[call].data()};
    tickets.push_back(renderer.submitCast({origins, directions}, targets, castSettings()));
  }
  tickets.erase(tickets.begin() + 1);
  tickets[1].take();
  EXPECT_TRUE(tickets[1].done());
  tickets[0].take();
  for (size_t i = 0; i < kCount; ++i) {
    EXPECT_NEAR(distances[0][i], 5, 1e-6);
    EXPECT_NEAR(distances[2][i], 27, 1e-5);
  }
}

// Of equal surfaces, a ray hits the last one by instance and then by triangle, wherever the hierarchy has them. The
// mesh has a square of two triangles 20 times, and the scene has it three times at the same place.
TEST_F(CastTest, HitsTheLastOfEqualSurfaces) {
  scene::Mesh mesh = squareMesh();
  const std::vector<uint32_t> square = mesh.indices;
  for (int copy = 1; copy < 20; ++copy) mesh.indices.insert(mesh.indices.end(), square.begin(), square.end());
  scene::Scene scene = oneMesh(mesh, true);
  scene.materials.resize(3, scene.materials[0]);
  scene.instances.resize(3, scene.instances[0]);
  for (uint32_t i = 0; i < 3; ++i) {
    scene.materials[i].data.id = 10 + i;
    scene.instances[i].material = i;
  }
  std::vector<dvec3> origins, directions;
  for (int i = 0; i < 100; ++i) {
    const double angle = 0.37 * i, side = i % 2 ? 1 : -1;
    origins.emplace_back(3 * std::cos(angle), 3 * std::sin(angle), side * (1 + 0.05 * i));
    directions.push_back(dvec3(0.009 * i * std::sin(angle), 0.008 * i * std::cos(angle), 0) - origins.back());
  }
  const CastHits hits = cast(scene, origins, directions);
  for (size_t i = 0; i < origins.size(); ++i) {
    EXPECT_NEAR(hits.distance[i], glm::length(directions[i]), 1e-5) << i;
    EXPECT_EQ(hits.material[i], 12u) << i;
    EXPECT_GE(hits.triangle[i], 38u) << i;
  }
}

// More rays than the device casts at once; neighbors differ by 1.5e-5.
TEST_F(CastTest, CastsManyRaysInOrder) {
  constexpr size_t kCount = 600'000;
  std::vector<dvec3> origins(kCount), directions(kCount, dvec3(0, 0, -1));
  for (size_t i = 0; i < kCount; ++i) origins[i] = dvec3(0.3, -0.2, 1 + 0x1p-16 * static_cast<double>(i));
  const CastHits hits = cast(oneMesh(squareMesh(), false), origins, directions);
  Largest error;
  for (size_t i = 0; i < kCount; ++i) error.add(std::abs(hits.distance[i] - origins[i].z));
  EXPECT_LT(error.value, 4e-6);
}

// An instance that its transform flattens is still a surface.
TEST_F(CastTest, HitsFlattenedInstances) {
  scene::Scene scene = oneMesh(sphereMesh(2), true);
  scene.instances[0].toWorld[2] = glm::dvec4(0);
  const CastHits hits = cast(scene, {dvec3(0.3, 0.4, 3), dvec3(0.3, 0.4, -3)}, {dvec3(0, 0, -1), dvec3(0, 0.1, 1)});
  EXPECT_FLOAT_EQ(hits.distance[0], 3);
  EXPECT_NEAR(hits.distance[1], 3 * std::sqrt(1.01), 1e-6);
}

}  // namespace
}  // namespace latelight::render::test
