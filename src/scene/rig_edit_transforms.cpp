// Moves nodes at rest, and what follows them; see scene/rig_edit.h.
#include <algorithm>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "scene/decompose.h"
#include "scene/rig_edit.h"
#include "scene/rig_edit_steps.h"

namespace latelight::scene {

namespace {

constexpr double kRoundingOfFloats = 1e-6;

bool isAnimated(const Rig& rig, uint32_t node) {
  const auto moves = [node](const Track& track) {
    return track.node == node && track.property <= AnimatedProperty::Scale;
  };
  return std::ranges::any_of(rig.animations, [&](const Animation& a) { return std::ranges::any_of(a.tracks, moves); });
}

// Returns a node of the rig with another transform.
RigNode withTransform(const Rig& rig, uint32_t node, const dmat4& parentFromNode, const std::string& owner) {
  RigNode to = rig.nodes[node];
  const bool animated = isAnimated(rig, node);
  const RigNode parts = decomposeTransform(parentFromNode);
  to.hasMatrix = !(decompositionError(parts) <= (animated ? kRoundingOfFloats : kRoundingOfDoubles));
  if (animated && to.hasMatrix)
    badUsage("the matrix of {} shears, but animations move the node: give one of a translation, a rotation and a scale",
             owner);
  to.matrix = parentFromNode;
  to.translation = parts.translation;
  to.rotation = parts.rotation;
  to.scale = parts.scale;
  return to;
}

// Moves everything that follows the nodes of the rig that `isMoved` marks to the rest pose. If memory runs out, a part
// has moved; another call moves the rest. Changes are logged first, so that copies on devices have every change.
void moveFollowers(Scene& scene, const Pose& rest, const std::vector<bool>& isMoved) {
  const Rig& rig = scene.rig;
  const auto follows = [&](int node) { return node >= 0 && isMoved[rig.sceneNodes[static_cast<size_t>(node)]]; };
  const auto worldOf = [&](int node) { return rest.world[rig.sceneNodes[static_cast<size_t>(node)]]; };
  for (size_t i = 0; i < scene.nodes.size(); ++i)
    if (follows(static_cast<int>(i))) scene.nodes[i].toWorld = toWorldFromGltf() * worldOf(static_cast<int>(i));
  const std::vector<dmat4> transforms = instanceTransforms(scene, rest);
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    Instance& instance = scene.instances[i];
    if (instance.removed || instance.placed || !follows(static_cast<int>(instance.node))) continue;
    scene.edits.instances.note(i);
    instance.toWorld = transforms[i];
  }
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    if (scene.lights[i].removed || !follows(scene.lights[i].node)) continue;
    scene.edits.lights.note(i);
    placeLight(scene.lights[i], worldOf(scene.lights[i].node));
  }
  for (Camera& camera : scene.cameras)
    if (follows(camera.node)) placeCamera(camera, worldOf(camera.node));
  for (uint32_t i = 0; i < scene.meshes.size(); ++i) {
    const auto& deformation = scene.meshes[i].deformation;
    if (scene.meshes[i].removed || !deformation || deformation->skin < 0) continue;
    const Skin& skin = rig.skins[static_cast<size_t>(deformation->skin)];
    if (std::ranges::none_of(skin.joints, [&](uint32_t joint) { return isMoved[joint]; })) continue;
    scene.edits.meshes.note(i);
    poseByJoints(scene, rest, scene.meshes[i]);
  }
}

// The rest pose with another transform of a node. Throws Error(Usage), with the rig unchanged, if it is not finite.
Pose restWith(Scene& scene, uint32_t rigNode, RigNode to, const std::string& owner) {
  RigNode before = std::exchange(scene.rig.nodes[rigNode], std::move(to));
  try {
    return restPose(scene);
  } catch (const std::bad_alloc&) {
    scene.rig.nodes[rigNode] = std::move(before);
    throw;
  } catch (const Error&) {
    scene.rig.nodes[rigNode] = std::move(before);
    badUsage("{} would get a transform that is not finite, or a node below it would", owner);
  }
}

}  // namespace

void setNodeTransform(Scene& scene, uint32_t node, const dmat4& parentFromNode) {
  const uint32_t rigNode = rigNodeOf(scene, node);
  const std::string owner = fmt::format("the node {}", printable(scene.nodes[node].path));
  if (scene.nodes[node].added > 0) badUsage("{} is that of an added instance: move the instance", owner);
  checkNodeTransform({.hasMatrix = true, .matrix = parentFromNode}, parentFromNode, owner);
  std::vector<bool> isMoved(scene.rig.nodes.size());
  const Pose rest = restWith(scene, rigNode, withTransform(scene.rig, rigNode, parentFromNode, owner), owner);
  scene.nodes[node].local = parentFromNode;
  isMoved[rigNode] = true;
  for (const uint32_t index : scene.rig.order)
    if (const int parent = scene.rig.nodes[index].parent; parent >= 0 && isMoved[static_cast<size_t>(parent)])
      isMoved[index] = true;
  moveFollowers(scene, rest, isMoved);
}

}  // namespace latelight::scene
