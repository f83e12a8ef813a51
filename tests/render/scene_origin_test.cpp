#include "render/gpu_scene/scene_origin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "render/gpu_scene/instances.h"

namespace latelight::render {
namespace {

using glm::dvec3;

std::vector<WorldSphere> spheresAt(const std::vector<dvec3>& centers, double radius = 1) {
  std::vector<WorldSphere> spheres;
  for (const dvec3& center : centers) spheres.push_back({.center = center, .radius = radius});
  return spheres;
}

// The origin whatever the previous one was, in any order.
dvec3 originOf(std::vector<WorldSphere> spheres) {
  const dvec3 origin = sceneOrigin(spheres, dvec3(0));
  EXPECT_EQ(sceneOrigin(spheres, origin), origin);
  EXPECT_EQ(sceneOrigin(spheres, dvec3(64000, -1e9, 64)), origin);
  std::ranges::shuffle(spheres, std::mt19937(7));
  EXPECT_EQ(sceneOrigin(spheres, dvec3(0)), origin);
  return origin;
}

TEST(SceneOrigin, IsAMultipleOf64MetersNearTheScene) {
  EXPECT_EQ(originOf({}), dvec3(0));
  EXPECT_EQ(originOf(spheresAt({{1023, -1023, 0}})), dvec3(0));
  EXPECT_EQ(originOf(spheresAt({{1024, -1030, 1e8}})), dvec3(1024, -1024, 1e8));
  EXPECT_EQ(originOf(spheresAt({{5000, 0, 0}, {5010, 0, 0}, {5020, 0, 0}})), dvec3(4992, 0, 0));
}

TEST(SceneOrigin, StaysNearMostInstancesHoweverFarOthersAre) {
  std::vector<dvec3> centers(9, dvec3(6400, 0, -64000));
  for (const double far : {1e4, 1e8, 1e18, 1e300}) {
    centers.resize(9);
    for (int i = 0; i < 4; ++i) {
      centers.emplace_back(far, -far, far);
      EXPECT_EQ(originOf(spheresAt(centers)), dvec3(6400, 0, -64000)) << far;
    }
  }
}

TEST(SceneOrigin, WeighsInstancesByTheInverseOfTheirSquaredRadius) {
  std::vector<WorldSphere> spheres = spheresAt({{1e5, 0, 0}, {1e5, 0, 0}, {1e5, 0, 0}}, 2);  // weights 1/4
  spheres.push_back({.center = {64000, 0, 0}, .radius = 1});
  EXPECT_EQ(originOf(spheres), dvec3(64000, 0, 0));
  spheres.push_back({.center = {1e5, 0, 0}, .radius = 1.9});
  EXPECT_EQ(originOf(spheres), dvec3(99968 + 64, 0, 0)) << "1e5 is nearest to 1563 * 64";
  for (int i = 0; i < 100; ++i) spheres.push_back({.center = dvec3(-1e6), .radius = 1e5});
  EXPECT_EQ(originOf(spheres), dvec3(100032, 0, 0)) << "large grounds do not count";
}

TEST(SceneOrigin, IgnoresHiddenInstancesAndThoseThatAreNotFinite) {
  std::vector<WorldSphere> spheres = spheresAt({{64000, 0, 0}});
  for (int i = 0; i < 5; ++i) spheres.push_back({.center = dvec3(1e6)});  // hidden
  for (int i = 0; i < 5; ++i)
    spheres.push_back({.center = dvec3(std::numeric_limits<double>::infinity(), 1e6, 1e6), .radius = 1});
  EXPECT_EQ(originOf(spheres), dvec3(64000, 0, 0));
}

TEST(SceneOrigin, OfManyInstancesIsTheMedianOfASortedList) {
  std::mt19937 random(3);
  std::vector<WorldSphere> spheres;
  std::vector<double> sorted;
  for (int i = 0; i < 100'001; ++i) {
    const double x = std::lognormal_distribution(12.0, 3.0)(random);
    spheres.push_back({.center = {x, 0, 0}, .radius = 0.5});
    sorted.push_back(x);
  }
  std::ranges::sort(sorted);
  EXPECT_NEAR(sceneOrigin(spheres, dvec3(0)).x, sorted[50'000], 32);
}

}  // namespace
}  // namespace latelight::render
