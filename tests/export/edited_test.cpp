// Edits of the nodes of glTF files: animations, visibility, morph targets and skins that a program adds or replaces, at
// rest, in animations, and after an export. Places are compared with the transforms that the files and edits state.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "app/folder.h"
#include "export/export.h"
#include "scene/edit.h"
#include "scene/gltf_builder.h"
#include "scene/rig_edit.h"

namespace latelight::scene::test {
namespace {

constexpr double kHalf = 0.70710678118654752;  // the sine and cosine of 45 degrees

Scene loadedAgain(const Scene& scene) {
  const app::Folder folder;
  exports::exportScene(scene, folder.at("edited.glb"));
  return loadGltf(folder.at("edited.glb"), {.morphTargets = true});
}

uint32_t nodeNamed(const Scene& scene, const std::string& path) {
  const auto found = std::ranges::find(scene.nodes, path, &Node::path);
  EXPECT_NE(found, scene.nodes.end()) << path;
  return static_cast<uint32_t>(found - scene.nodes.begin());
}

uint32_t instanceAt(const Scene& scene, const std::string& path) {
  const auto found = std::ranges::find(scene.instances, nodeNamed(scene, path), &Instance::node);
  EXPECT_NE(found, scene.instances.end()) << path;
  return static_cast<uint32_t>(found - scene.instances.begin());
}

void addTrack(Scene& scene, const std::string& path, AnimatedProperty property, std::vector<float> values) {
  Track track;
  track.interpolation = Interpolation::Step;
  track.times = {0};
  track.values = std::move(values);
  track.node = rigNodeOf(scene, nodeNamed(scene, path));
  track.property = property;
  addAnimation(scene, {.name = "play", .tracks = {track}});
}

Pose lastPose(const Scene& scene) {
  return poseAt(scene, {.animations = {static_cast<uint32_t>(scene.rig.animations.size() - 1)}}, 0);
}

// The first vertex of a node's first instance in a pose, in glTF's frame.
dvec3 vertexOf(const Scene& scene, const Pose& pose, const std::string& path) {
  const uint32_t i = instanceAt(scene, path);
  const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
  vec3 vertex = mesh.positions[0];
  if (mesh.deformation && !pose.empty()) {
    const Deformation& d = *mesh.deformation;
    std::vector<mat4> joints;
    std::vector<float> weights;
    if (d.skin >= 0) joints = jointMatrices(scene.rig.skins[size_t(d.skin)], pose);
    if (d.weightsNode >= 0) weights = pose.weights[size_t(d.weightsNode)];
    vertex = deform(d, joints, weights).positions[0];
  }
  return toGltfFromWorld() * instanceTransforms(scene, pose)[i] * glm::dvec4(vertex, 1);
}

void expectAt(const dvec3& place, const dvec3& expected) {
  EXPECT_LT(glm::length(place - expected), 1e-5) << place.x << ' ' << place.y << ' ' << place.z;
}

TEST(EditedNodes, ThoseOfFilesWithoutAnimationsAreAnimated) {
  GltfBuilder file = triangleFile();
  file.root["nodes"][0] = {{"name", "a"}, {"mesh", 0}, {"translation", {0, 1, 0}}, {"rotation", {0, 0, kHalf, kHalf}}};
  const int child = file.add("nodes", {{"name", "child"}, {"mesh", 0}, {"translation", {0, 3, 0}}});
  file.node({{"name", "mirror"}, {"translation", {20, 0, 0}}, {"scale", {1, -1, 1}}, {"children", {child}}});
  Scene scene = file.load();
  addTrack(scene, "/a", AnimatedProperty::Translation, {5, 0, 0});
  const Scene again = loadedAgain(scene);
  for (const Scene* shown : {&std::as_const(scene), &again}) {
    expectAt(vertexOf(*shown, {}, "/a"), {0, 1, 0});
    expectAt(vertexOf(*shown, lastPose(*shown), "/a"), {5, 0, 0});
  }
  // The mirrored child is at (0, -3), which the rotation by 90 degrees turns to (3, 0).
  addTrack(scene, "/mirror", AnimatedProperty::Rotation, {0, 0, float(kHalf), float(kHalf)});
  expectAt(vertexOf(scene, {}, "/mirror/child"), {20, -3, 0});
  expectAt(vertexOf(scene, lastPose(scene), "/mirror/child"), {23, 0, 0});
}

// `isAnimated`: the file has an animation of another node, and therefore a rig.
GltfBuilder hiddenFile(bool isAnimated) {
  GltfBuilder file = triangleFile();
  file.root["nodes"][0]["name"] = "other";
  const int child = file.add("nodes", {{"name", "child"}, {"mesh", 0}});
  file.use("KHR_node_visibility");
  file.node(
      {{"name", "group"}, {"children", {child}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  if (!isAnimated) return file;
  const int times = file.accessor(file.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const int places = file.vectors(std::vector<vec3>{{0, 0, 0}, {0, 0, 0}});
  file.add("animations", {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                          {"samplers", {{{"input", times}, {"output", places}}}}});
  return file;
}

TEST(EditedNodes, ThoseBelowHiddenNodesAreHidden) {
  for (const bool isAnimated : {false, true}) {
    Scene scene = hiddenFile(isAnimated).load();
    addNode(scene, {.name = "added", .parent = int(nodeNamed(scene, "/group")), .parts = {{0, 0}}});
    addTrack(scene, "/other", AnimatedProperty::Translation, {1, 0, 0});
    const Scene again = loadedAgain(scene);
    for (const Scene* shown : {&std::as_const(scene), &again}) {
      for (const char* path : {"/group/added", "/group/child"}) {
        const Instance& instance = shown->instances[instanceAt(*shown, path)];
        EXPECT_FALSE(isShown(*shown, {}, instance)) << path << isAnimated;
        EXPECT_FALSE(isShown(*shown, lastPose(*shown), instance)) << path << isAnimated;
      }
      EXPECT_TRUE(isShown(*shown, {}, shown->instances[instanceAt(*shown, "/other")]));
    }
    EXPECT_TRUE(isHiddenAtRest(scene, nodeNamed(scene, "/group/added")));
    EXPECT_FALSE(isHiddenAtRest(scene, nodeNamed(scene, "/other")));
    addTrack(scene, "/group", AnimatedProperty::Visible, {1});
    for (const char* path : {"/group/added", "/group/child"}) {
      const Instance& instance = scene.instances[instanceAt(scene, path)];
      EXPECT_FALSE(isShown(scene, {}, instance)) << path << isAnimated;
      EXPECT_TRUE(isShown(scene, lastPose(scene), instance)) << path << isAnimated;
    }
  }
}

TEST(EditedNodes, MorphTargetsThatTheFileDoesNotAnimateAreAnimated) {
  GltfBuilder file = triangleFile();
  file.primitive()["targets"] = {{{"POSITION", file.positions({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}})}}};
  file.root["meshes"][0]["weights"] = {0.5};
  file.root["nodes"][0]["name"] = "face";
  file.node({{"name", "twin"}, {"mesh", 0}, {"translation", {5, 0, 0}}});
  EXPECT_FALSE(file.load().meshes[0].morphable);  // scenes that no program edits
  Scene still = file.load({.morphTargets = true});
  ASSERT_EQ(still.meshes.size(), 1u);
  EXPECT_FALSE(still.meshes[0].deformation);
  Scene moved = file.load({.morphTargets = true});
  addTrack(moved, "/twin", AnimatedProperty::Translation, {5, 0, 0});
  Scene stillAgain = loadedAgain(still), movedAgain = loadedAgain(moved);
  for (Scene* scene : {&still, &moved, &stillAgain, &movedAgain}) {
    addTrack(*scene, "/face", AnimatedProperty::Weights, {2});
    const Scene again = loadedAgain(*scene);
    for (const Scene* shown : {&std::as_const(*scene), &again}) {
      expectAt(vertexOf(*shown, {}, "/face"), {0, 0, 0.5});
      expectAt(vertexOf(*shown, {}, "/twin"), {5, 0, 0.5});
      expectAt(vertexOf(*shown, lastPose(*shown), "/face"), {0, 0, 2});
      expectAt(vertexOf(*shown, lastPose(*shown), "/twin"), {5, 0, 0.5});
    }
  }
}

// Vertices of a skinned mesh are relative to a point near its joints, which other meshes do not have.
TEST(EditedNodes, ReplacedSkinnedMeshesAreAtOnePlace) {
  GltfBuilder file = triangleFile();
  const std::vector<uint8_t> joints(12, 0);
  file.primitive()["attributes"]["JOINTS_0"] = file.accessor(file.view(joints), kUnsignedByte, "VEC4", 3);
  file.primitive()["attributes"]["WEIGHTS_0"] = file.vectors(std::vector<vec4>(3, {1, 0, 0, 0}));
  const int joint = file.node({{"name", "joint"}, {"translation", {5000, 0, 0}}});
  file.root["nodes"][0] = {{"name", "skinned"}, {"mesh", 0}, {"skin", file.add("skins", {{"joints", {joint}}})}};
  Scene scene = file.load();
  addTrack(scene, "/joint", AnimatedProperty::Translation, {5000, 0, 0});
  const Mesh skinned = scene.meshes[0], plain = triangleFile().load().meshes[0];
  for (const bool isSkinned : {true, false, true}) {
    setMesh(scene, 0, isSkinned ? skinned : plain);
    expectAt(vertexOf(scene, {}, "/skinned"), {isSkinned ? 5000 : 0, 0, 0});
    expectAt(vertexOf(scene, lastPose(scene), "/skinned"), {isSkinned ? 5000 : 0, 0, 0});
  }
}

}  // namespace
}  // namespace latelight::scene::test
