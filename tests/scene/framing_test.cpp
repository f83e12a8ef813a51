#include "scene/framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "shared/projection.h"

namespace latelight::scene {
namespace {

Scene boxScene(vec3 min, vec3 max) {
  Scene scene;
  Mesh mesh;
  mesh.positions = {min, max};
  mesh.boundsMin = min;
  mesh.boundsMax = max;
  scene.meshes.push_back(std::move(mesh));
  Instance instance;
  instance.toWorld = toWorldFromGltf();
  scene.instances.push_back(instance);
  return scene;
}

// NDC of a point in the file's frame, with its view depth in z.
glm::dvec3 seen(const Camera& camera, vec3 gltf, double aspect) {
  const glm::dmat4 toView = glm::inverse(glm::dmat4(camera.toWorld));
  const glm::dvec3 v = toView * glm::dmat4(toWorldFromGltf()) * glm::dvec4(glm::dvec3(gltf), 1.0);
  const double scale = 1.0 / std::tan(0.5 * double{camera.verticalFov});
  return {scale / aspect * v.x / v.y, scale * v.z / v.y, v.y};
}

vec3 corner(vec3 min, vec3 max, int i) {
  return {i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z};
}

struct Extent {
  const char* name;
  vec3 min, max;
};
const Extent kExtents[] = {
    {"cube", {-1, -1, -1}, {1, 1, 1}},      {"away from the origin", {100, 50, -300}, {101, 53, -298}},
    {"flat floor", {-5, 0, -5}, {5, 0, 5}}, {"flat wall", {-5, 0, 0}, {5, 3, 0}},
    {"side wall", {0, 0, -4}, {0, 2, 4}},   {"needle", {0, 0, 0}, {0, 10, 0}},
    {"tiny", vec3(-1e-9f), vec3(1e-9f)},    {"huge", vec3(-1e12f), vec3(1e12f)},
    {"corridor", {-1, 0, -500}, {1, 2, 5}},
};

TEST(Framing, KeepsEveryCornerInThePictureAndTouchesItsMargin) {
  for (const Extent& e : kExtents) {
    const Scene scene = boxScene(e.min, e.max);
    for (const float aspect : {0.1f, 0.4f, 0.5625f, 1.0f, 1.5f, 1.7778f, 2.4f, 4.0f, 12.0f}) {
      const Camera camera = frameScene(scene, aspect);
      double widest = 0;
      for (int i = 0; i < 8; ++i) {
        const glm::dvec3 p = seen(camera, corner(e.min, e.max, i), aspect);
        EXPECT_GT(p.z, camera.nearClip) << e.name << " at aspect " << aspect;
        widest = std::max({widest, std::abs(p.x), std::abs(p.y)});
      }
      EXPECT_LT(widest, 0.99) << e.name << " at aspect " << aspect;
      EXPECT_GT(widest, 0.9) << e.name << " at aspect " << aspect;
    }
  }
}

// Objects that are large compared with the scene are not in front of the near plane, and none is so far away that its
// device depth becomes a denormal float.
TEST(Framing, NearPlanesCutNothingAndLeaveRoomForWhatIsFar) {
  for (const Extent& e : kExtents) {
    const Scene scene = boxScene(e.min, e.max);
    const vec3 center = (e.min + e.max) * 0.5f;
    const float size = glm::length(e.max - e.min);
    for (const Camera& camera :
         {frameScene(scene, 1.5f), orbitCamera(scene, 0.3f, 0.2f), orbitCamera(scene, 0.3f, 0.2f, size * 1000),
          lookAt(scene, center, center + vec3(size)), lookAt(scene, center + vec3(size) * 0.5f, e.min)}) {
      int exponent = 0;
      EXPECT_EQ(std::frexp(camera.nearClip, &exponent), 0.5f) << e.name;  // a power of two
      EXPECT_LT(camera.nearClip, 1e-9f * size) << e.name;
      const double farthest = 1e6 * (glm::length(vec3(camera.toWorld[3]) - center) + double{size});
      EXPECT_GT(camera.nearClip / farthest, double{std::numeric_limits<float>::min()}) << e.name;
      EXPECT_TRUE(std::isnormal(camera.nearClip) && std::isnormal(1 / camera.nearClip)) << e.name;
    }
  }
}

TEST(Framing, LooksFromTheFrontTheRightAndAbove) {
  const Camera camera = frameScene(boxScene(vec3(-1), vec3(1)), 1.5f);
  const vec3 eye = toGltfFromWorld() * camera.toWorld[3];
  EXPECT_GT(eye.z, 1.0f);
  EXPECT_GT(eye.x, 0.5f);
  EXPECT_GT(eye.y, 0.5f);
  EXPECT_GT(eye.z, eye.x);
}

TEST(Framing, ShowsSomethingOfWhatHasNoExtent) {
  const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const Extent extents[] = {{"point", vec3(3), vec3(3)},
                            {"far point", vec3(1e8f), vec3(1e8f)},
                            {"infinite", vec3(-infinity), vec3(infinity)},
                            {"not a number", vec3(nan), vec3(nan)}};
  Scene empty;
  for (const float aspect : {0.5f, 2.0f}) {
    for (const Extent& e : extents) {
      const Camera camera = frameScene(boxScene(e.min, e.max), aspect);
      EXPECT_TRUE(std::isfinite(camera.toWorld[3].x)) << e.name;
      EXPECT_GT(camera.nearClip, 0.0f) << e.name;
      if (e.min.x == e.max.x) {
        const glm::dvec3 p = seen(camera, e.min, aspect);
        EXPECT_LT(std::abs(p.x), 0.5) << e.name;
        EXPECT_LT(std::abs(p.y), 0.5) << e.name;
      }
    }
    EXPECT_GT(frameScene(empty, aspect).nearClip, 0.0f);
  }
  EXPECT_THROW(frameScene(empty, 0.0f), Error);
  EXPECT_THROW(frameScene(empty, nan), Error);
}

TEST(Orbit, StandsWhereItsAnglesSay) {
  const vec3 min(1, 2, 3), max(3, 4, 5), center(2, 3, 4);
  const Scene scene = boxScene(min, max);
  const struct {
    float azimuth, elevation;
    vec3 eye;
  } cases[] = {{0, 0, {0, 0, 10}},
               {shared::kPi / 2, 0, {10, 0, 0}},
               {shared::kPi, 0, {0, 0, -10}},
               {0, shared::kPi / 2, {0, 10, 0}},
               {0, -shared::kPi / 2, {0, -10, 0}}};
  for (const auto& c : cases) {
    const Camera camera = orbitCamera(scene, c.azimuth, c.elevation, 10.0f, 0.8f);
    const vec3 eye = toGltfFromWorld() * camera.toWorld[3];
    EXPECT_LT(glm::length(eye - center - c.eye), 1e-4f);
    const glm::dvec3 p = seen(camera, center, 1.0);
    EXPECT_NEAR(p.x, 0, 1e-5);
    EXPECT_NEAR(p.y, 0, 1e-5);
    EXPECT_NEAR(p.z, 10, 1e-4);
    const glm::mat3 axes(camera.toWorld);
    EXPECT_NEAR(glm::determinant(axes), 1, 1e-5f);
  }
}

TEST(Orbit, FitsTheBoundsFromEverySide) {
  const vec3 min(-3, 0, -1), max(2, 7, 1);
  const Scene scene = boxScene(min, max);
  for (const float aspect : {0.6f, 1.0f, 1.8f}) {
    for (float azimuth = 0; azimuth < 6.3f; azimuth += 0.4f) {
      for (float elevation = -1.5f; elevation < 1.6f; elevation += 0.5f) {
        const Camera camera = orbitCamera(scene, azimuth, elevation, {}, 0.7f, aspect);
        for (int i = 0; i < 8; ++i) {
          const glm::dvec3 p = seen(camera, corner(min, max, i), aspect);
          EXPECT_LT(std::max(std::abs(p.x), std::abs(p.y)), 1.0);
          EXPECT_GT(p.z, camera.nearClip);
        }
      }
    }
  }
}

TEST(Orbit, RefusesWhatShowsNothing) {
  const Scene scene = boxScene(vec3(-1), vec3(1));
  EXPECT_THROW(orbitCamera(scene, NAN, 0), Error);
  EXPECT_THROW(orbitCamera(scene, 0, 0, 0.0f), Error);
  EXPECT_THROW(orbitCamera(scene, 0, 0, -1.0f), Error);
  EXPECT_THROW(orbitCamera(scene, 0, 0, {}, 0.0f), Error);
  EXPECT_THROW(orbitCamera(scene, 0, 0, {}, 3.2f), Error);
  EXPECT_THROW(orbitCamera(scene, 0, 0, {}, 1e-30f), Error);
}

TEST(LookAt, HasTheFilesUpUp) {
  const Scene scene = boxScene(vec3(-1), vec3(1));
  const Camera camera = lookAt(scene, {0, 0, 5}, {0, 0, 0});
  const glm::dvec3 up = seen(camera, {0, 1, 0}, 1.0), right = seen(camera, {1, 0, 0}, 1.0);
  EXPECT_GT(up.y, 0.1);
  EXPECT_NEAR(up.x, 0, 1e-6);
  EXPECT_NEAR(up.z, 5, 1e-5);
  EXPECT_GT(right.x, 0.1);
  EXPECT_LT(camera.nearClip, 4.0f);

  Scene zUp = boxScene(vec3(-1), vec3(1));
  zUp.yUp = false;
  const Camera other = lookAt(zUp, {0, -5, 0}, {0, 0, 0});
  EXPECT_EQ(other.toWorld[3], glm::dvec4(0, -5, 0, 1));
  EXPECT_NEAR(other.toWorld[2].z, 1, 1e-6f);
}

TEST(LookAt, LooksStraightUpAndDownToo) {
  const Scene scene = boxScene(vec3(-1), vec3(1));
  for (const float y : {-5.0f, 5.0f}) {
    const Camera camera = lookAt(scene, {0, y, 0}, {0, 0, 0});
    EXPECT_NEAR(glm::determinant(glm::mat3(camera.toWorld)), 1, 1e-5f);
    EXPECT_GT(seen(camera, {0, 0, -1}, 1.0).y, 0.1);  // the point behind the scene appears at the top
  }
  EXPECT_GT(seen(lookAt(scene, {0, 5, 0}, {0, 0, 0}, vec3(1, 0, 0)), {1, 0, 0}, 1.0).y, 0.1);
}

TEST(LookAt, RefusesWhatHasNoDirection) {
  const Scene scene = boxScene(vec3(-1), vec3(1));
  EXPECT_THROW(lookAt(scene, vec3(1), vec3(1)), Error);
  EXPECT_THROW(lookAt(scene, vec3(NAN), vec3(1)), Error);
  EXPECT_THROW(lookAt(scene, {0, 0, 5}, vec3(0), vec3(0, 0, 1)), Error);
  EXPECT_THROW(lookAt(scene, {0, 0, 5}, vec3(0), vec3(0)), Error);
}

}  // namespace
}  // namespace latelight::scene
