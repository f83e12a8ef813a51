// Nodes, skins, morph targets and animations that a program adds, against closed forms. tests/python/test_animation.py
// compares such scenes with the same scenes loaded from files.
#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include "test_device.h"

namespace latelight {
namespace {

MeshData facingSquare() {
  MeshData mesh;
  mesh.name = "square";
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.normals = std::vector(4, std::array{0.0f, 0.0f, 1.0f});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

// The distance from (0.25, 0, 10) along -Z at a time.
float distanceAt(Scene& scene, double time) {
  Renderer renderer(scene, latelight::test::testDevice());
  Options options;
  options.time = time;
  const std::array<double, 3> origin{0.25, 0, 10}, down{0, 0, -1};
  return renderer.cast({&origin, 1}, {&down, 1}, options).distance.at(0);
}

TEST(AnimationApi, WeightsAndJointsDeformOneMesh) {
  Scene scene;
  const std::string root = scene.addNode({.name = "root"});
  const std::string joint = scene.addNode({.name = "joint", .parent = root});
  EXPECT_EQ(joint, "/root/joint");
  MeshData data = facingSquare();
  data.targets = {{.positions = std::vector(4, std::array{0.0f, 0.0f, 2.0f})}};
  data.skin = scene.addSkin({.joints = {joint}, .inverseBind = {}});
  data.joints = {0, 0, 0, 0};
  data.jointWeights = {1, 2, 3, 4};  // scaled to 1
  const Handle<Mesh> mesh = scene.addMesh(data);
  EXPECT_TRUE(scene.mesh(mesh).deforms);
  const std::string face =
      scene.addNode({.name = "face", .parts = {{mesh, scene.addMaterial({.doubleSided = true})}}, .weights = {0.5f}});
  EXPECT_EQ(scene.mesh(mesh).boundsMax[2], 1);  // at rest: half of the target
  scene.addAnimation("both", {{.node = face, .property = AnimatedProperty::Weights, .times = {0, 1}, .values = {0, 1}},
                              {.node = joint,
                               .property = AnimatedProperty::Translation,
                               .interpolation = Interpolation::Step,
                               .times = {0, 1},
                               .values = {0, 0, 0, 0, 0, 3}}});
  ASSERT_EQ(scene.animations().size(), 1u);
  EXPECT_EQ(scene.animations()[0].duration, 1);
  EXPECT_NEAR(distanceAt(scene, 0.25), 9.5f, 1e-5f);
  EXPECT_NEAR(distanceAt(scene, 1), 5, 1e-5f);
}

TEST(AnimationApi, ReplacedMeshesHaveTheirNewDeformation) {
  Scene scene;
  MeshData data = facingSquare();
  data.targets = {{.positions = std::vector(4, std::array{0.0f, 0.0f, 1.0f})}};
  const Handle<Mesh> mesh = scene.addMesh(data);
  const std::string face = scene.addNode({.name = "face", .parts = {{mesh, scene.addMaterial({.doubleSided = true})}}});
  scene.addAnimation("w", {{.node = face, .property = AnimatedProperty::Weights, .times = {0}, .values = {1}}});
  EXPECT_NEAR(distanceAt(scene, 0), 9, 1e-5f);
  data.targets[0].positions = std::vector(4, std::array{0.0f, 0.0f, 4.0f});
  scene.setMesh(mesh, data);
  EXPECT_NEAR(distanceAt(scene, 0), 6, 1e-5f);
  scene.setMesh(mesh, facingSquare());
  EXPECT_FALSE(scene.mesh(mesh).deforms);
  EXPECT_NEAR(distanceAt(scene, 0), 10, 1e-5f);
}

}  // namespace
}  // namespace latelight
