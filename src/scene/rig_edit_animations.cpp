// Adds animations; see scene/rig_edit.h.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/reserve.h"
#include "scene/edit.h"
#include "scene/rig_edit.h"
#include "scene/rig_edit_steps.h"

namespace latelight::scene {

namespace {

constexpr const char* kPropertyNames[] = {"translation", "rotation", "scale", "weights", "visible"};

void checkTimes(const Track& track, const std::string& owner) {
  if (track.times.empty()) badUsage("{} has no times", owner);
  for (const float time : track.times)
    if (!(std::isfinite(time) && time >= 0))
      badUsage("{} has the time {}: times must be finite and at least 0", owner, time);
  if (!std::ranges::is_sorted(track.times)) badUsage("{} has times that fall: they must ascend", owner);
}

void checkValues(const Track& track, const std::string& owner) {
  const size_t keys = track.interpolation == Interpolation::Cubic ? 3 : 1;
  const size_t expected = track.times.size() * track.width * keys;
  if (track.values.size() != expected)
    badUsage("{} has {} values, but its {} times require {}", owner, track.values.size(), track.times.size(), expected);
  for (const float value : track.values)
    if (!std::isfinite(value)) badUsage("{} has a value that is not finite", owner);
  if (track.property == AnimatedProperty::Visible && track.interpolation != Interpolation::Step)
    badUsage("{} must have steps, because there is nothing between visible and hidden", owner);
  if (track.property != AnimatedProperty::Rotation) return;
  for (size_t key = 0; key < track.times.size(); ++key) {
    const float* q = &track.values[(key * keys + (keys == 3 ? 1 : 0)) * 4];
    if (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0)
      badUsage("{} has the rotation 0 0 0 0: a quaternion must have a length above 0", owner);
  }
}

// Completes a track's width, and checks it.
void checkTrack(const Scene& scene, const std::string& animation, Track& track) {
  const RigNode& node = scene.rig.nodes[track.node];
  const bool moves = track.property != AnimatedProperty::Weights && track.property != AnimatedProperty::Visible;
  const auto found = std::ranges::find(scene.rig.sceneNodes, track.node);
  const std::string path = scene.nodes[static_cast<size_t>(found - scene.rig.sceneNodes.begin())].path;
  const std::string owner =
      fmt::format("the channel \"{}\" of the node {} in the animation \"{}\"",
                  kPropertyNames[static_cast<size_t>(track.property)], printable(path), printable(animation));
  track.width = track.property == AnimatedProperty::Rotation  ? 4
                : track.property == AnimatedProperty::Weights ? static_cast<uint32_t>(node.weights.size())
                : track.property == AnimatedProperty::Visible ? 1
                                                              : 3;
  if (moves && node.hasMatrix) badUsage("{} cannot be animated, because its transform is a matrix", owner);
  if (track.width == 0) badUsage("{} cannot be animated, because its meshes have no morph targets", owner);
  checkTimes(track, owner);
  checkValues(track, owner);
}

// The mesh with its morph targets, which have the weights of a node.
Mesh morphedBy(const Scene& scene, const MorphableMesh& source, uint32_t rigNode) {
  Mesh mesh = source.mesh;
  mesh.deformation = weightedBy(rigNode, *mesh.deformation);
  if (mesh.deformation->skin >= 0)
    poseByJoints(scene, restPose(scene), mesh);  // edits may have moved the joints
  else
    poseAtRest(scene, mesh);
  return mesh;
}

// Gives the instances of a node the morph targets of their meshes. If other nodes show a mesh, they keep the one
// without.
void addMorphTargets(Scene& scene, uint32_t rigNode) {
  const auto found = std::ranges::find(scene.rig.sceneNodes, rigNode);
  const auto node = static_cast<uint32_t>(found - scene.rig.sceneNodes.begin());
  std::set<uint32_t> meshes;
  for (const Instance& instance : scene.instances)
    if (instance.node == node && scene.meshes[instance.mesh].morphable) meshes.insert(instance.mesh);
  for (const uint32_t mesh : meshes) {
    Mesh morphed = morphedBy(scene, *scene.meshes[mesh].morphable, rigNode);
    const auto isOfOther = [&](const Instance& i) { return i.mesh == mesh && i.node != node; };
    if (std::ranges::none_of(scene.instances, isOfOther)) {
      setMesh(scene, mesh, std::move(morphed));
      continue;
    }
    const uint32_t added = addMesh(scene, std::move(morphed));
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
      if (scene.instances[i].node != node || scene.instances[i].mesh != mesh) continue;
      scene.edits.instances.note(i);
      scene.instances[i].mesh = added;
    }
  }
}

}  // namespace

void addAnimation(Scene& scene, Animation animation) {
  if (animation.tracks.empty()) badUsage("the animation \"{}\" moves nothing", printable(animation.name));
  animation.duration = 0;
  for (Track& track : animation.tracks) {
    checkTrack(scene, animation.name, track);
    animation.duration = std::max(animation.duration, track.times.back());
  }
  if (animation.name.empty()) animation.name = fmt::format("animation{}", scene.rig.animations.size());
  reserveMore(scene.rig.animations, 1);
  for (const Track& track : animation.tracks)
    if (track.property == AnimatedProperty::Weights) addMorphTargets(scene, track.node);
  scene.rig.animations.push_back(std::move(animation));
}

}  // namespace latelight::scene
