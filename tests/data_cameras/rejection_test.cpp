// The surroundings of a point compared with closed forms for boxes and spheres, and the cameras that are rejected
// because of them.
#include "data/cameras/surroundings.h"
#include "data/random.h"
#include "data_cameras/support.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"

namespace latelight::data::test {
namespace {

double distanceToSurface(dvec3 p, const scene::BoxesBox& box) {
  const dvec3 low = dvec3(box.min) - p, high = p - dvec3(box.max), outside = glm::max(dvec3(0), glm::max(low, high));
  if (glm::length(outside) > 0) return glm::length(outside);
  const dvec3 depth = -glm::max(low, high);
  return std::min({depth.x, depth.y, depth.z});
}
bool contains(const scene::BoxesBox& box, dvec3 p) {
  return glm::all(glm::lessThan(dvec3(box.min), p)) && glm::all(glm::lessThan(p, dvec3(box.max)));
}

TEST(SurroundingsTest, AreThoseOfBoxes) {
  const Surroundings surroundings(boxes());
  Random random(3, 1, "boxes");
  int insides = 0;
  for (int i = 0; i < 3000; ++i) {
    const dvec3 p(random.between(-5, 5), random.between(-1.5, 5), random.between(-6.5, 3));
    double nearest = 1e9;
    bool inside = false;
    for (const scene::BoxesBox& box : scene::boxesBoxes()) {
      nearest = std::min(nearest, distanceToSurface(p, box));
      inside = inside || contains(box, p);
    }
    insides += inside;
    EXPECT_NEAR(surroundings.nearest(p), nearest, 1e-6);
    EXPECT_EQ(surroundings.nearest(p, 0.1) < 0.1, surroundings.nearest(p) < 0.1);
    ASSERT_GT(nearest, 1e-6);
    EXPECT_EQ(surroundings.inside(p), inside) << p.x << " " << p.y << " " << p.z;
  }
  EXPECT_GT(insides, 100);
}

// From points with integer coordinates, rays pass along edges and through corners.
TEST(SurroundingsTest, EdgesCountOnce) {
  const Surroundings surroundings(boxes());
  for (double x = -4; x <= 4; x += 0.125)
    for (const double z : {-5.5, -1.0, -0.25, 0.125})
      for (const double y : {-0.5, 0.125, 1.0}) {
        bool inside = false;
        double nearest = 1;
        for (const scene::BoxesBox& box : scene::boxesBoxes()) {
          inside = inside || contains(box, {x, y, z});
          nearest = std::min(nearest, distanceToSurface({x, y, z}, box));
        }
        if (nearest < 1e-6) continue;
        EXPECT_EQ(surroundings.inside({x, y, z}), inside) << x << " " << y << " " << z;
      }
}

TEST(SurroundingsTest, AreThoseOfSpheresThatAreScaledAndTurnedInsideOut) {
  scene::Scene scene = scene::load("builtin:spheres");
  const dvec3 center(scene::spheresCenter(0, 0));
  const auto winding = [&](const glm::mat4& change) {
    scene::Scene changed = scene::load("builtin:spheres");
    for (scene::Instance& instance : changed.instances) instance.toWorld = instance.toWorld * glm::dmat4(change);
    return Surroundings(changed).inside(center + dvec3(0.1, 0.1, 0.05));
  };
  EXPECT_TRUE(winding(glm::mat4(1)));
  // mirrored, with its front faces still outward
  EXPECT_TRUE(winding(glm::mat4(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)));
  const Surroundings surroundings(scene);
  for (const double r : {0.0, 0.2, 0.43, 0.45}) {
    const dvec3 p = center + dvec3(0, 0, r);
    EXPECT_EQ(surroundings.inside(p), r < scene::kSpheresRadius) << r;
    // The spheres consist of triangles, which lie slightly inside the true spheres.
    EXPECT_NEAR(surroundings.nearest(p), std::abs(scene::kSpheresRadius - r), 0.002);
  }
  // A room: the same box with its front faces inward.
  for (scene::Mesh& mesh : scene.meshes)
    for (size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  EXPECT_FALSE(Surroundings(scene).inside(center));
}

TEST(RejectionTest, LeavesNoCameraInsideOrTooNear) {
  const auto spec = [](const char* more) {
    return std::string(R"({"type": "box", "count": 300, "min": [-5, -1, -6], "max": [5, 4, 3])") + more + "}";
  };
  const auto worst = [&](const std::string& job) {
    double nearest = 1e9;
    int insides = 0;
    for (const JobCamera& camera : made(job))
      for (const scene::BoxesBox& box : scene::boxesBoxes()) {
        nearest = std::min(nearest, distanceToSurface(eyeOf(camera), box));
        insides += contains(box, eyeOf(camera));
      }
    return std::pair(insides, nearest);
  };
  EXPECT_GT(worst(spec(R"(, "rejectInside": false)")).first, 10);
  EXPECT_EQ(worst(spec("")).first, 0);
  EXPECT_LT(worst(spec("")).second, 0.3);
  const auto [insides, nearest] = worst(spec(R"(, "clearance": 0.5)"));
  EXPECT_EQ(insides, 0);
  EXPECT_GE(nearest, 0.5 - 1e-6);
}

TEST(RejectionTest, GridsKeepTheOtherPoints) {
  const std::string sphere = R"({"type": "sphere", "count": 100, "radius": 2, "target": [0, 0, 0], "rejectInside": )";
  const auto all = made(sphere + "false}"), free = made(sphere + "true}");
  ASSERT_LT(free.size(), all.size());
  size_t i = 0;
  for (const JobCamera& camera : free) {
    while (i < all.size() && all[i].name != camera.name) ++i;
    ASSERT_LT(i, all.size());
    EXPECT_EQ(camera.camera.toWorld, all[i].camera.toWorld);
  }
}

}  // namespace
}  // namespace latelight::data::test
