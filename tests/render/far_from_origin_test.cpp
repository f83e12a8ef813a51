// The tests move a scene and its cameras together. No output of the renderer may change except `position`, which moves
// with them. The reference is the same scene at the origin, which other tests compare with ray casters and closed
// forms.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "long_tests.h"
#include "models/models.h"
#include "render/frame/view.h"
#include "render/support.h"
#include "scene/animation.h"
#include "scene/builtin/builtin.h"
#include "scene/framing.h"
#include "scene/gltf_builder.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using output::Aov;

constexpr uint32_t kWide = 120, kHigh = 80;

// The offsets have no special direction and few bits, so doubles add them to a scene's coordinates with an error of at
// most 1e-8 m.
dvec3 offsetOf(double size) {
  return size * dvec3(1, -0.75, 0.125);
}

scene::Camera moved(scene::Camera camera, dvec3 by) {
  camera.toWorld[3] += glm::dvec4(by, 0);
  return camera;
}

// Moves a scene during the lifetime of this object, because scenes are not copied.
class MovedScene {
 public:
  MovedScene(scene::Scene& scene, dvec3 by) : scene_(scene), instances_(scene.instances), lights_(scene.lights) {
    for (scene::Instance& instance : scene.instances) instance.toWorld[3] += glm::dvec4(by, 0);
    for (scene::Light& light : scene.lights) light.position += by;
  }
  ~MovedScene() {
    scene_.instances = instances_;
    scene_.lights = lights_;
  }
  MovedScene(const MovedScene&) = delete;

 private:
  scene::Scene& scene_;
  std::vector<scene::Instance> instances_;
  std::vector<scene::Light> lights_;
};

// Returns the larger value, or infinity if `now` is not a number.
double worse(double found, double now) {
  return now <= found ? found : std::isnan(now) ? std::numeric_limits<double>::infinity() : now;
}

struct FarDifference {
  double depth = 0, normal = 0, motion = 0, position = 0;  // largest, where both show the same id
  double otherIds = 0, otherColors = 0;                    // fractions of the pixels
};

FarDifference differenceOf(const output::FrameOutput& a, const output::FrameOutput& b, dvec3 offset) {
  const bool motion = std::ranges::count(a.aovs, Aov::Motion, &output::AovImage::aov) > 0;
  FarDifference found;
  const size_t pixels = size_t{a.width} * a.height;
  for (size_t i = 0; i < pixels; ++i) {
    const uint32_t id = imageOf(a, Aov::Id).ids[i];
    int most = 0;
    for (size_t c = 0; c < 4; ++c)
      most = std::max(most, std::abs(int{a.display[4 * i + c]} - int{b.display[4 * i + c]}));
    found.otherColors += most > 2;
    if (id != imageOf(b, Aov::Id).ids[i]) {
      ++found.otherIds;
      continue;
    }
    if (id == 0) continue;
    const double da = imageOf(a, Aov::Depth).values[i], db = imageOf(b, Aov::Depth).values[i];
    found.depth = worse(found.depth, std::abs(da - db) / da);
    found.normal =
        worse(found.normal, glm::length(vec3At(imageOf(a, Aov::GeoNormal), i) - vec3At(imageOf(b, Aov::GeoNormal), i)));
    if (motion)
      found.motion =
          worse(found.motion, glm::length(vec2At(imageOf(a, Aov::Motion), i) - vec2At(imageOf(b, Aov::Motion), i)));
    const dvec3 pa = dvec3(vec3At(imageOf(a, Aov::Position), i)) + offset, pb(vec3At(imageOf(b, Aov::Position), i));
    // The rounding of each coordinate to a float, plus the uncertainty of the pixel's own point.
    const dvec3 rounding = glm::abs(pa) * 6.0e-8 + 1e-5 * (1 + da);
    found.position = worse(found.position, glm::length((pa - pb) / rounding));
  }
  found.otherIds /= double(pixels);
  found.otherColors /= double(pixels);
  return found;
}

class FarFromOrigin : public RenderTest {
 protected:
  static output::FrameOutput render(const scene::Scene& scene, const scene::Camera& camera, const Settings& settings,
                                    const scene::Camera& before) {
    Renderer renderer(device(), scene, nullptr);
    SceneState moment;
    if (std::ranges::count(settings.aovs, Aov::Motion) > 0) {
      moment.previousCameras = {before};
      moment.nextCameras = {camera};
    }
    return renderer.render({&camera, 1}, settings, moment).front();
  }

  static Settings settings(Raster raster) {
    Settings s = settingsOf(kWide, kHigh, {Aov::Depth, Aov::Id, Aov::GeoNormal, Aov::Motion, Aov::Position});
    s.axes = Axes::ZUp;  // the axes of the offsets
    s.display = true;
    s.raster = raster;
    s.shadows = ShadowFormat::D32;
    return s;
  }

  static void expectTheSame(const std::string& name, scene::Scene& scene, const scene::Camera& camera,
                            Settings settings, std::initializer_list<double> offsets, bool motion = true) {
    if (!motion) std::erase(settings.aovs, Aov::Motion);  // the limit below is that of projections
    scene::Camera before = camera;
    before.toWorld[3] += glm::dvec4(0.03, -0.02, 0.01, 0);
    const output::FrameOutput reference = render(scene, camera, settings, before);
    for (const double size : offsets) {
      const dvec3 by = offsetOf(size);
      const MovedScene there(scene, by);
      const output::FrameOutput far = render(scene, moved(camera, by), settings, moved(before, by));
      const FarDifference d = differenceOf(reference, far, by);
      fmt::print(
          "{} at {:g} m: depth {:.1e}, normal {:.1e}, motion {:.1e} px, position {:.2f}, ids {:.4f}, colors {:.4f}\n",
          name, size, d.depth, d.normal, d.motion, d.position, d.otherIds, d.otherColors);
      EXPECT_LE(d.depth, 2e-6) << name << " at " << size;
      EXPECT_LE(d.normal, 1e-5) << name << " at " << size;
      EXPECT_LE(d.motion, 1e-3) << name << " at " << size;
      EXPECT_LE(d.position, 2) << name << " at " << size;
      EXPECT_LE(d.otherIds, 5e-4) << name << " at " << size;
      // Shadow maps of a sun are snapped to texels of the world, so edges of shadows may move by one texel.
      EXPECT_LE(d.otherColors, 0.02) << name << " at " << size;
    }
  }
};

TEST_F(FarFromOrigin, ScenesLookAsAtTheOriginInBothRasters) {
  scene::Scene intricate = scene::load(models::modelPath("intricate.glb").string());
  scene::Scene textured = scene::load(models::modelPath("textured.glb").string());
  scene::Scene house = scene::makeBuiltin("hall,triangles=50k,lights=20"), boxes = scene::makeBuiltin("boxes"),
               spheres = scene::makeBuiltin("spheres"), triangles = scene::makeBuiltin("triangles,count=2k");
  const bool full = latelight::test::runsInFull();
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    const std::string in = raster == Raster::Hardware ? " by hardware" : " in compute";
    for (const auto& [name, scene] : {std::pair<std::string, scene::Scene*>{"hall", &house},
                                      {"boxes", &boxes},
                                      {"spheres", &spheres},
                                      {"triangles", &triangles},
                                      {"intricate", &intricate},
                                      {"textured", &textured}})
      if (full)
        expectTheSame(name + in, *scene, cameraOf(*scene, kWide, kHigh), settings(raster), {1e4, 1e6, 1e8});
      else
        expectTheSame(name + in, *scene, cameraOf(*scene, kWide, kHigh), settings(raster), {1e8});
  }
}

// Without shadows, colors do not depend on the snapping of a sun's shadow maps.
TEST_F(FarFromOrigin, UnshadowedLightIsTheSame) {
  scene::Scene boxes = scene::makeBuiltin("boxes");
  const scene::Camera camera = cameraOf(boxes, kWide, kHigh);
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    Settings s = settings(raster);
    s.shadows = ShadowFormat::None;
    const output::FrameOutput reference = render(boxes, camera, s, camera);
    for (const double size : {1e4, 1e6, 1e8}) {
      const MovedScene there(boxes, offsetOf(size));
      const scene::Camera far = moved(camera, offsetOf(size));
      const FarDifference d = differenceOf(reference, render(boxes, far, s, far), offsetOf(size));
      fmt::print("unshadowed at {:g} m: colors {:.5f}, motion {:.1e}\n", size, d.otherColors, d.motion);
      EXPECT_LE(d.otherColors, 5e-4) << size;
    }
  }
}

TEST_F(FarFromOrigin, LightCullingLensesAndSamplesLookAsAtTheOrigin) {
  scene::Scene house = scene::makeBuiltin("hall,triangles=50k,lights=20");
  const scene::Camera camera = cameraOf(house, kWide, kHigh);
  for (const char* technique : {"tiled", "clustered", "volumes", "forward"}) {
    Settings s = settings(Raster::Compute);
    s.lighting = &findTechnique(technique);
    if (s.lighting->forward || std::string(technique) == "volumes") s.raster = Raster::Hardware;
    expectTheSame(technique, house, camera, s, {1e6});
  }
  scene::Camera fisheye = camera;
  fisheye.lens = scene::Lens{scene::LensModel::Fisheye, kWide, kHigh, 40, 40, kWide / 2.0, kHigh / 2.0, {}};
  expectTheSame("fisheye", house, fisheye, settings(Raster::Compute), {1e6}, false);
  Settings samples = settings(Raster::Compute);
  samples.aa.samples = 4;
  expectTheSame("four samples", house, camera, samples, {1e6});
}

// An animated skin whose joints the file itself places far away.
TEST_F(FarFromOrigin, SkinsMoveAsAtTheOrigin) {
  const scene::test::TemporaryFolder folder;
  const auto load = [&](dvec3 foot) {
    scene::test::writeBytes(folder.path() / "skinned.glb", models::skinnedModel(foot));
    return scene::load((folder.path() / "skinned.glb").string());
  };
  const auto renderPosed = [&](const scene::Scene& scene, const scene::Camera& camera, Raster raster) {
    const scene::Playback playback = scene::choosePlayback(scene, "", false);
    Renderer renderer(device(), scene, nullptr);
    const auto pose = [&](double seconds) { return scene::poseAt(scene, playback, seconds); };
    const SceneState moment{.poses = {pose(0.3), pose(0.35), pose(0.4)}};
    return renderer.render({&camera, 1}, settings(raster), moment).front();
  };
  const scene::Scene here = load(dvec3(0));
  const scene::Camera camera = cameraOf(here, kWide, kHigh);
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    const output::FrameOutput reference = renderPosed(here, camera, raster);
    const auto& motion = imageOf(reference, Aov::Motion).values;
    EXPECT_GT(std::abs(*std::ranges::max_element(motion, {}, [](float v) { return std::abs(v); })), 1) << "it moves";
    for (const double size : {1e4, 1e6, 1e8}) {
      const dvec3 foot = offsetOf(size), by(scene::toWorldFromGltf() * glm::dvec4(foot, 1));
      const FarDifference d = differenceOf(reference, renderPosed(load(foot), moved(camera, by), raster), by);
      fmt::print("skin at {:g} m: depth {:.1e}, normal {:.1e}, motion {:.1e} px, position {:.2f}, ids {:.4f}\n", size,
                 d.depth, d.normal, d.motion, d.position, d.otherIds);
      EXPECT_LE(d.depth, 1e-5) << size;
      EXPECT_LE(d.normal, 1e-3) << size;
      EXPECT_LE(d.motion, 1e-2) << size;
      EXPECT_LE(d.position, 2) << size;
      EXPECT_LE(d.otherIds, 5e-4) << size;
    }
  }
}

// A ground of two triangles, 20,000 km wide, viewed from 1.7 m above it. The expected depth follows from the pixels'
// rays in double precision.
TEST_F(FarFromOrigin, AGroundAsWideAsAPlanetIsWhereItIs) {
  scene::SceneBuilder builder("ground");
  builder.scene.meshes = {squareMesh()};
  findBounds(builder.scene.meshes.front());
  builder.scene.materials = {scene::plainMaterial("m", glm::vec3(0.8f), 0, 1)};
  const glm::mat4 up(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);  // a rotation without rounding
  builder.addInstance("ground", builder.kRoot, 0, 0, glm::scale(glm::mat4(1), glm::vec3(1e7f)) * up);
  const scene::Scene scene = std::move(builder.scene);
  constexpr double kHeight = 1.7;
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    for (const dvec3 place :
         {dvec3(0, 0, kHeight), dvec3(123.25, -456.5, kHeight), dvec3(3200000.5, 2100000.25, kHeight)}) {
      scene::Camera camera = frontPerspective(0.8f, 0);
      const double pitch = 0.3;
      camera.toWorld = glm::rotate(glm::translate(glm::dmat4(1), place), 0.4, dvec3(0, 0, 1)) *
                       glm::rotate(glm::dmat4(1), -pitch, dvec3(1, 0, 0));
      Settings s = settings(raster);
      s.display = false;
      const output::FrameOutput frame = render(scene, camera, s, camera);
      const double half = std::tan(0.5 * double{camera.verticalFov});
      double worst = 0, moved = 0;
      size_t missing = 0, seen = 0;
      for (size_t i = 0; i < size_t{kWide} * kHigh; ++i) {
        const double x = (2 * (double(i % kWide) + 0.5) / kWide - 1) * half * kWide / kHigh;
        const double z = (1 - 2 * (double(i / kWide) + 0.5) / kHigh) * half;
        const dvec3 ray(camera.toWorld * glm::dvec4(x, 1, z, 0));
        const double depth = -kHeight / ray.z, got = imageOf(frame, Aov::Depth).values[i];
        EXPECT_EQ(ray.z >= 0, std::isinf(got)) << i;
        if (ray.z >= 0) continue;
        ++seen;
        missing += std::isinf(got);
        // A pixel's ray is a float vector. Toward the horizon, its rounding dominates the error of depth.
        worst = worse(worst, std::abs(got - depth) / depth / (1 + depth / 100));
        const dvec3 normal(vec3At(imageOf(frame, Aov::GeoNormal), i));
        moved = worse(moved, glm::length(vec2At(imageOf(frame, Aov::Motion), i)));
        EXPECT_LT(glm::length(normal - dvec3(0, 0, 1)), 1e-5);
      }
      fmt::print("{} at {:g}, {:g}: {} pixels, depth off by {:.1e}\n",
                 raster == Raster::Hardware ? "hardware" : "compute", place.x, place.y, seen, worst);
      EXPECT_GT(seen, size_t{kWide} * kHigh / 2);
      EXPECT_EQ(missing, 0u);
      // The graphics pipeline interpolates depth between vertices that it snaps to a grid.
      EXPECT_LE(worst, raster == Raster::Hardware ? 2e-4 : 4e-6);
      EXPECT_LE(moved, 1e-3);  // nothing moves
    }
}

// Positions relative to a nearby point are as precise as at the origin.
TEST_F(FarFromOrigin, PositionsMayBeRelativeToAPointNearby) {
  scene::Scene boxes = scene::makeBuiltin("boxes");
  const scene::Camera camera = cameraOf(boxes, kWide, kHigh);
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    Settings s = settings(raster);
    const output::FrameOutput reference = render(boxes, camera, s, camera);
    const dvec3 by = offsetOf(1e8);
    s.positionOrigin.point = by;
    const MovedScene there(boxes, by);
    const output::FrameOutput far = render(boxes, moved(camera, by), s, moved(camera, by));
    double worst = 0;
    size_t compared = 0;
    EXPECT_EQ(imageOf(far, Aov::Id).ids, imageOf(reference, Aov::Id).ids);
    for (size_t i = 0; i < size_t{kWide} * kHigh; ++i)
      if (imageOf(far, Aov::Id).ids[i] != 0 && ++compared) {
        // The device rounds a position to a float relative to its own origin, at most 32 m away along each axis, and
        // the output is rounded again: two errors of half a unit in the last place, in three coordinates.
        const glm::vec3 there = vec3At(imageOf(far, Aov::Position), i),
                        here = vec3At(imageOf(reference, Aov::Position), i);
        const double places = 1.2e-7 * (glm::length(here) + 64);
        worst = worse(worst, glm::length(there - here) / (1.8 * places));
      }
    EXPECT_GT(compared, size_t{kWide} * kHigh / 10);
    fmt::print("{}: positions off by {:.2f} of their rounding\n", raster == Raster::Hardware ? "hardware" : "compute",
               worst);
    EXPECT_LE(worst, raster == Raster::Hardware ? 4 : 1);  // hardware interpolates over triangles 24 m wide
  }
}

// An eye is a pair of floats. None of these numbers is a float, and a pair is within 2^-48 of a double.
TEST_F(FarFromOrigin, EyesArePairsOfFloats) {
  scene::Camera camera;
  camera.toWorld[3] = glm::dvec4(0.1, -2000000.2, 3000.3, 1);
  const shared::View view = makeView(camera, kWide, kHigh);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NE(view.eyeLow[i], 0) << i;
    EXPECT_NEAR(double{view.eye[i]} + double{view.eyeLow[i]}, camera.toWorld[3][i],
                std::abs(camera.toWorld[3][i]) * 0x1p-48)
        << i;
  }
}

// Survey files have vertices far from the origin, with cameras near these vertices.
TEST_F(FarFromOrigin, VerticesMayBeFarFromTheirNode) {
  scene::Scene boxes = scene::makeBuiltin("boxes");
  const scene::Camera camera = cameraOf(boxes, kWide, kHigh);
  // Multiples of 2^-10 m, which floats represent exactly at 4096 m.
  for (scene::Mesh& mesh : boxes.meshes) {
    for (glm::vec3& position : mesh.positions) position = glm::round(position * 1024.0f) / 1024.0f;
    findBounds(mesh);
  }
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    const output::FrameOutput reference = render(boxes, camera, settings(raster), camera);
    const glm::vec3 by(4096, -2048, 1024);
    for (const float sign : {1.0f, -1.0f}) {
      for (scene::Mesh& mesh : boxes.meshes) {
        for (glm::vec3& position : mesh.positions) position += sign * by;
        findBounds(mesh);
      }
      for (scene::Instance& instance : boxes.instances)
        instance.toWorld = glm::translate(instance.toWorld, dvec3(-sign * by));
      if (sign < 0) break;
      const FarDifference d = differenceOf(reference, render(boxes, camera, settings(raster), camera), dvec3(0));
      EXPECT_LE(d.depth, 2e-6);
      EXPECT_LE(d.normal, 1e-5);
      EXPECT_LE(d.motion, 1e-3);
      EXPECT_LE(d.position, 2);
      EXPECT_LE(d.otherIds, 5e-4);
      EXPECT_LE(d.otherColors, 5e-3);
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
