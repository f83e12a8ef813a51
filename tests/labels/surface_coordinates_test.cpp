// The outputs of coordinates on surfaces (object-position, nocs, barycentric, triangle, tangent, bitangent) compared
// with closed forms and with an independent ray caster. Expected values are computed in double precision from the
// scene's plain data: the ray through the pixel's center and the plane of the triangle.
#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/parallel.h"
#include "models/models.h"
#include "render/reference_caster.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "scene/objects.h"
#include "scene/scene_builder.h"

namespace latelight::render::test {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

const std::vector<Aov> kCoordinates{Aov::ObjectPosition, Aov::Nocs,      Aov::Barycentric, Aov::Triangle,
                                    Aov::Tangent,        Aov::Bitangent, Aov::Part,        Aov::Position};

// A placement of a mesh: p -> move + turn * (scale * p), whose object frame is move and turn.
struct Place {
  dvec3 move;
  double turn;
  dvec3 about, scale;

  dmat4 rigid() const { return glm::rotate(glm::translate(dmat4(1), move), turn, glm::normalize(about)); }
  dmat4 full() const { return glm::scale(rigid(), scale); }
};

// The camera looks along -Z at the origin, as in glTF.
const Place kPlaces[] = {{{0.2, 0.1, -0.3}, 0.7, {1, 2, 0.5}, {0.9, 0.6, 1.2}},
                         {{-1.6, 0.4, -1}, -1.1, {0.2, 1, -1}, {0.5, 0.5, 0.5}},
                         {{1.7, -0.3, 0.4}, 2.4, {1, -0.4, 0.3}, {0.3, 0.8, 0.4}},
                         {{0, -1.4, -4}, -1.45, {1, 0, 0}, {6, 6, 1}},
                         {{-0.9, 1.5, 0.5}, 0.3, {0, 0, 1}, {1e-3, 1.5e-3, 1e-3}}};

scene::Scene placedScene() {
  scene::SceneBuilder builder("root");
  scene::Scene& scene = builder.scene;
  scene.meshes = {sphereMesh(1), squareMesh(), sphereMesh(400)};
  scene.materials.push_back(scene::plainMaterial("plain", vec3(1), 0, 1));
  scene.materials.back().data.flags |= shared::kMaterialDoubleSided;
  for (size_t i = 0; i < std::size(kPlaces); ++i) {
    const uint32_t mesh = i == 3 ? 1 : i == 4 ? 2 : 0;
    builder.addInstance("object" + std::to_string(i), builder.kRoot, mesh, 0, glm::mat4(kPlaces[i].full()));
    scene.instances.back().toWorld = scene::toWorldFromGltf() * kPlaces[i].full();
  }
  return std::move(scene);
}

struct Ray {  // world space
  dvec3 origin, direction;
};

// The center of a pixel through a camera, in double precision.
class Rays {
 public:
  Rays(const scene::Camera& camera, uint32_t width, uint32_t height) : camera_(camera), size_(width, height) {
    if (camera.lens) lens_.emplace(scene::scaledTo(*camera.lens, width, height));
  }
  std::optional<Ray> through(dvec2 pixel) const {
    const dvec3 eye(camera_.toWorld[3]);
    const glm::dmat3 axes(camera_.toWorld);
    if (lens_) {
      const std::optional<dvec3> d = lens_->unproject(pixel);
      if (!d) return std::nullopt;
      return Ray{eye, axes * dvec3(d->x, d->z, -d->y)};
    }
    const double up = camera_.orthographic ? camera_.yHalf : std::tan(0.5 * camera_.verticalFov);
    const dvec2 ndc = dvec2(2, -2) * (pixel / size_ - 0.5) - dvec2(camera_.principal);
    const dvec2 place = ndc * dvec2(up * size_.x / size_.y, up);
    if (camera_.orthographic) return Ray{eye + axes * dvec3(place.x, 0, place.y), axes[1]};
    return Ray{eye, axes * dvec3(place.x, 1, place.y)};
  }

 private:
  scene::Camera camera_;
  dvec2 size_;
  std::optional<scene::LensProjection> lens_;
};

struct Expected {
  dvec3 weights, mesh;  // barycentric coordinates, and the point in the mesh's object space
  double cosine;        // between the triangle's normal and the ray
};

Expected onTriangle(const scene::Scene& scene, const scene::Instance& instance, uint32_t triangle, const Ray& ray) {
  const scene::Mesh& mesh = scene.meshes[instance.mesh];
  dvec3 local[3], world[3];
  for (size_t i = 0; i < 3; ++i) {
    local[i] = mesh.positions[mesh.indices[3 * size_t{triangle} + i]];
    world[i] = dvec3(instance.toWorld * glm::dvec4(local[i], 1));
  }
  const dvec3 n = glm::cross(world[1] - world[0], world[2] - world[0]);
  const dvec3 at = ray.origin + ray.direction * (glm::dot(n, world[0] - ray.origin) / glm::dot(n, ray.direction));
  Expected e{};
  for (int i = 0; i < 3; ++i)
    e.weights[i] =
        glm::dot(n, glm::cross(world[(i + 2) % 3] - world[(i + 1) % 3], at - world[(i + 1) % 3])) / glm::dot(n, n);
  e.mesh = e.weights.x * local[0] + e.weights.y * local[1] + e.weights.z * local[2];
  e.cosine = std::abs(glm::dot(n, ray.direction)) / (glm::length(n) * glm::length(ray.direction));
  return e;
}

struct Worst {
  double object = 0, nocs = 0, barycentric = 0;  // object: over the diagonal of its box
  size_t compared = 0, differ = 0;
};

class SurfaceCoordinatesTest : public RenderTest {
 protected:
  static constexpr uint32_t kWidth = 128, kHeight = 96;

  static output::FrameOutput renderBy(Raster raster, const scene::Scene& scene, const scene::Camera& camera) {
    Settings settings = settingsOf(kWidth, kHeight, kCoordinates);
    settings.raster = raster;
    return renderOne(device(), scene, camera, settings);
  }

  // Compares with the caster's triangles. `boxOf`: the object coordinates of a vertex of an instance.
  template <typename ObjectOf>
  static Worst compare(const scene::Scene& scene, const scene::Camera& camera, const output::FrameOutput& frame,
                       ObjectOf&& objectOf) {
    scene::Camera pinhole = camera;
    pinhole.lens.reset();
    const ReferenceCaster caster(scene, pinhole, kWidth, kHeight);
    const Rays rays(camera, kWidth, kHeight);
    const glm::dmat3 toView = glm::transpose(glm::dmat3(camera.toWorld));
    Worst worst;
    for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
      const dvec2 center(i % kWidth + 0.5, i / kWidth + 0.5);
      const std::optional<Ray> ray = rays.through(center);
      const std::optional<Hit> hit = !ray          ? std::nullopt
                                     : camera.lens ? caster.castAlong(toView * ray->direction)
                                                   : caster.cast(center);
      const uint32_t part = imageOf(frame, Aov::Part).ids[i], triangle = imageOf(frame, Aov::Triangle).ids[i];
      if (part == 0) {
        EXPECT_EQ(triangle, 0u);
        for (const Aov aov : {Aov::ObjectPosition, Aov::Nocs, Aov::Barycentric, Aov::Tangent, Aov::Bitangent})
          EXPECT_EQ(vec3At(imageOf(frame, aov), i), vec3(0));
        worst.differ += hit.has_value();
        continue;
      }
      if (!hit || hit->part != part || hit->triangle != triangle) {
        ++worst.differ;
        continue;
      }
      ++worst.compared;
      const scene::Instance& instance = scene.instances[hit->instance];
      const Expected e = onTriangle(scene, instance, triangle, *ray);
      scene::Extent box;
      for (const scene::Instance& other : scene.instances)
        if (other.id == instance.id)
          for (const vec3& p : scene.meshes[other.mesh].positions) box.add(objectOf(other, dvec3(p)));
      const dvec3 object = objectOf(instance, e.mesh), size = box.high - box.low;
      const dvec3 nocs = (object - 0.5 * (box.low + box.high)) / glm::length(size) + 0.5;
      // Rounding of the ray and of the rotations in floats moves the point by this share of the distance, along the
      // surface by 1 / cosine times as much.
      const double slack = std::min(1.0, 5 * e.cosine);
      worst.object =
          std::max(worst.object, slack * glm::length(dvec3(vec3At(imageOf(frame, Aov::ObjectPosition), i)) - object) /
                                     glm::length(size));
      worst.nocs = std::max(
          worst.nocs, slack * glm::length(dvec3(vec3At(imageOf(frame, Aov::Nocs), i)) - glm::clamp(nocs, 0.0, 1.0)));
      const dvec3 weights(vec3At(imageOf(frame, Aov::Barycentric), i));
      EXPECT_NEAR(weights.x + weights.y + weights.z, 1, 1e-6);
      worst.barycentric = std::max(worst.barycentric, slack * glm::length(weights - e.weights));
    }
    return worst;
  }

  static void expectExact(const Worst& worst, size_t covered) {
    EXPECT_GT(worst.compared, covered);
    EXPECT_LE(worst.differ, worst.compared / 200) << "pixels at edges";
    EXPECT_LE(worst.object, 1e-5);
    EXPECT_LE(worst.nocs, 1e-5);
    EXPECT_LE(worst.barycentric, 1e-4);
  }
};

const auto kScaled = [](const scene::Instance& instance, dvec3 p) { return kPlaces[instance.node - 1].scale * p; };

TEST_F(SurfaceCoordinatesTest, ObjectPositionsAreThoseOfTheMesh) {
  const scene::Scene scene = placedScene();
  scene::Camera camera = frontPerspective(0.9f, 5);
  camera.principal = {0.1f, -0.05f};
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    expectExact(compare(scene, camera, renderBy(raster, scene, camera), kScaled), 6000);
  const scene::Camera across = frontCamera(2.5f, 8);
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    expectExact(compare(scene, across, renderBy(raster, scene, across), kScaled), 4000);
}

TEST_F(SurfaceCoordinatesTest, ThroughLenses) {
  const scene::Scene scene = placedScene();
  scene::Camera camera = frontPerspective(0.9f, 4);
  camera.lens = scene::Lens{scene::LensModel::Fisheye, kWidth, kHeight, 40, 41, 62, 50, {-0.03, 0.012, -0.004, 0.0007}};
  expectExact(compare(scene, camera, renderBy(Raster::Compute, scene, camera), kScaled), 2000);
  camera.lens = scene::Lens{.model = scene::LensModel::Equirectangular};
  expectExact(compare(scene, camera, renderBy(Raster::Compute, scene, camera), kScaled), 800);
}

// A group has the frame of its topmost node, without that node's scale.
TEST_F(SurfaceCoordinatesTest, AGroupHasOneFrame) {
  const Place group{{0.3, -0.2, 0}, 0.8, {0.3, 1, 0.2}, {1.5, 1.5, 1.5}};
  const Place parts[] = {{{-0.7, 0, 0}, 0.4, {0, 1, 1}, {0.5, 0.7, 0.5}},
                         {{0.6, 0.3, 0.2}, -0.9, {1, 0, 0}, {0.4, 0.4, 0.6}}};
  scene::SceneBuilder builder("root");
  scene::Scene& scene = builder.scene;
  scene.meshes = {sphereMesh(1)};
  scene.materials.push_back(scene::plainMaterial("plain", vec3(1), 0, 1));
  const uint32_t top = builder.addNode("group", builder.kRoot, glm::mat4(group.full()));
  scene.nodes[top].toWorld = scene::toWorldFromGltf() * group.full();
  for (const Place& part : parts) {
    const uint32_t node = builder.addInstance("part", top, 0, 0, glm::mat4(part.full()));
    scene.instances.back().toWorld = scene::toWorldFromGltf() * group.full() * part.full();
    scene.instances.back().id = scene.nodes[node].id = scene.nodes[top].id;
  }
  const scene::Camera camera = frontPerspective(0.8f, 5);
  const auto inGroup = [&](const scene::Instance& instance, dvec3 p) {
    const Place& part = parts[&instance - scene.instances.data()];
    return group.scale * dvec3(part.full() * glm::dvec4(p, 1));
  };
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    expectExact(compare(scene, camera, renderBy(raster, scene, camera), inGroup), 1500);
}

// Mirroring is part of the coordinates, because the frame is rigid. A matrix does not state the mirrored axis: it is X.
TEST_F(SurfaceCoordinatesTest, AMirroredMeshHasARightHandedFrame) {
  scene::SceneBuilder builder("root");
  builder.scene.meshes = {sphereMesh(1)};
  builder.scene.materials.push_back(scene::plainMaterial("plain", vec3(1), 0, 1));
  const dmat4 mirrored = glm::scale(kPlaces[0].rigid(), dvec3(-1.2, 0.7, 0.9));
  builder.addInstance("mirrored", builder.kRoot, 0, 0, glm::mat4(mirrored));
  builder.scene.instances.back().toWorld = scene::toWorldFromGltf() * mirrored;
  const scene::Camera camera = frontPerspective(0.8f, 4);
  const auto expected = [](const scene::Instance&, dvec3 p) { return dvec3(-1.2, 0.7, 0.9) * p; };
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    expectExact(compare(builder.scene, camera, renderBy(raster, builder.scene, camera), expected), 1000);
}

// --- tangents --------------------------------------------------------------------------------------------------------

// A square whose UV are turned by an angle, scaled by 2 and possibly mirrored, with or without tangents of its own.
scene::Mesh turnedSquare(float angle, bool mirrored, bool ownTangents) {
  scene::Mesh mesh = squareMesh();
  const glm::vec2 u(std::cos(angle), std::sin(angle)), v(mirrored ? -u.y : u.y, mirrored ? u.x : -u.x);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec2 p(mesh.positions[i]);
    mesh.attributes[i].uv0 = 2.0f * glm::vec2(glm::dot(p, u), glm::dot(p, v));
    mesh.attributes[i].tangent = ownTangents ? glm::vec4(u, 0, mirrored ? -1 : 1) : glm::vec4(0);
  }
  return mesh;
}

TEST_F(SurfaceCoordinatesTest, TangentsFollowTheTexture) {
  for (const bool mirrored : {false, true})
    for (const bool own : {false, true})
      for (const bool back : {false, true}) {
        constexpr float kAngle = 0.4f;
        scene::SceneBuilder builder("root");
        builder.scene.meshes = {turnedSquare(kAngle, mirrored, own)};
        builder.scene.materials.push_back(scene::plainMaterial("plain", vec3(1), 0, 1));
        builder.scene.materials.back().data.flags |= shared::kMaterialDoubleSided;
        const dmat4 turn = glm::rotate(dmat4(1), back ? 2.9 : 0.5, glm::normalize(dvec3(0.2, 1, 0.1)));
        builder.addInstance("square", builder.kRoot, 0, 0, glm::mat4(turn));
        builder.scene.instances.back().toWorld = scene::toWorldFromGltf() * turn;
        const dvec3 tangent = glm::dmat3(turn) * dvec3(std::cos(kAngle), std::sin(kAngle), 0);
        // The vertical axis of the texture's image, upward: against v.
        const dvec3 up = (mirrored ? -1.0 : 1.0) * (glm::dmat3(turn) * dvec3(-std::sin(kAngle), std::cos(kAngle), 0));
        for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
          const output::FrameOutput frame = renderBy(raster, builder.scene, frontPerspective(0.8f, 4));
          const size_t center = (kHeight / 2) * kWidth + kWidth / 2 + 5;
          EXPECT_LE(glm::length(dvec3(vec3At(imageOf(frame, Aov::Tangent), center)) - tangent), 1e-6);
          EXPECT_LE(glm::length(dvec3(vec3At(imageOf(frame, Aov::Bitangent), center)) - up), 1e-6);
        }
      }
}

// --- animation -------------------------------------------------------------------------------------------------------

SceneState stateOf(const scene::Scene& scene, double seconds, double next) {
  const scene::Playback playback = scene::choosePlayback(scene, "", false);
  const scene::Pose now = scene::poseAt(scene, playback, seconds);
  return {.poses = {now, now, scene::poseAt(scene, playback, next)}};
}

std::vector<vec3> deformedBy(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Pose& pose) {
  const scene::Deformation& d = *mesh.deformation;
  std::vector<glm::mat4> joints;
  if (d.skin >= 0) joints = scene::jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], pose);
  std::vector<float> weights;
  if (d.weightsNode >= 0) weights = pose.weights[static_cast<size_t>(d.weightsNode)];
  return scene::deform(d, joints, weights).positions;
}

// Object coordinates of deformed meshes are those at rest, and scene flow follows the deformation.
TEST_F(SurfaceCoordinatesTest, DeformationMovesSurfacesButNotTheirCoordinates) {
  for (const char* name : {"skinned.glb", "morphed.glb"}) {
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
    const SceneState state = stateOf(scene, 0.3, 0.45);
    for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
      std::vector<Aov> aovs = kCoordinates;
      aovs.push_back(Aov::SceneFlow);
      Settings settings = settingsOf(kWidth, kHeight, aovs);
      settings.raster = raster;
      Renderer renderer(device(), scene, nullptr);
      const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings, state).front());
      size_t compared = 0;
      double object = 0, flow = 0, longest = 0;
      for (const scene::Instance& instance : scene.instances) {
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        if (!mesh.deformation) continue;
        const std::vector<vec3> now = deformedBy(scene, mesh, state.poses.current),
                                next = deformedBy(scene, mesh, state.poses.next);
        for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
          if (imageOf(frame, Aov::Part).ids[i] != instance.part) continue;
          ++compared;
          const vec3 weights = vec3At(imageOf(frame, Aov::Barycentric), i);
          dvec3 rest(0), moved(0);
          for (int k = 0; k < 3; ++k) {
            const uint32_t vertex = mesh.indices[3 * imageOf(frame, Aov::Triangle).ids[i] + static_cast<uint32_t>(k)];
            rest += double{weights[k]} * dvec3(mesh.positions[vertex]);
            moved += double{weights[k]} * (dvec3(next[vertex]) - dvec3(now[vertex]));
          }
          object = std::max(object, glm::length(dvec3(vec3At(imageOf(frame, Aov::ObjectPosition), i)) - rest));
          flow = std::max(flow, glm::length(dvec3(vec3At(imageOf(frame, Aov::SceneFlow), i)) - moved));
          longest = std::max(longest, glm::length(moved));
        }
      }
      EXPECT_GT(compared, 300u) << name;
      EXPECT_GT(longest, 0.02) << name;
      EXPECT_LE(object, 1e-5) << name;
      EXPECT_LE(flow, 2e-6) << name;
    }
  }
}

// Blended surfaces appear with --data-surfaces any, in both rasters alike.
TEST_F(SurfaceCoordinatesTest, SurfacesAreThoseOfOtherOutputs) {
  scene::Scene scene = placedScene();
  scene.materials.push_back(scene.materials.front());
  scene.materials.back().data.flags |= shared::kMaterialBlended;
  scene.materials.back().data.baseColor.a = 0.5f;
  scene.instances[0].material = 1;
  const scene::Camera camera = frontPerspective(0.9f, 5);
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    for (const DataSurfaces surfaces : {DataSurfaces::Opaque, DataSurfaces::Any}) {
      Settings settings = settingsOf(kWidth, kHeight, kCoordinates);
      settings.raster = raster;
      settings.dataSurfaces = surfaces;
      const output::FrameOutput frame = renderOne(device(), scene, camera, settings);
      size_t blended = 0;
      for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
        const bool drawn = imageOf(frame, Aov::Part).ids[i] != 0;
        EXPECT_EQ(vec3At(imageOf(frame, Aov::Barycentric), i) != vec3(0), drawn);
        blended += imageOf(frame, Aov::Part).ids[i] == scene.instances[0].part;
      }
      EXPECT_EQ(blended > 500, surfaces == DataSurfaces::Any);
    }
}

}  // namespace
}  // namespace latelight::render::test
