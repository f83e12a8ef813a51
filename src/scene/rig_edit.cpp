// Adds nodes, skins and animations to a scene, and moves nodes; see scene/rig_edit.h.
#include "scene/rig_edit.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <new>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/reserve.h"
#include "scene/decompose.h"
#include "scene/edit.h"
#include "scene/edit_check.h"
#include "scene/edit_slots.h"
#include "scene/origin.h"

namespace latelight::scene {

namespace {

constexpr double kRoundingOfFloats = 1e-6;

// A node that the rig does not cover yet, except for its parent.
RigNode uncoveredNode(Scene& scene, size_t index) {
  if (index < scene.fileNodes.size()) return std::move(scene.fileNodes[index]);
  const Node& node = scene.nodes[index];
  if (node.added > 0) return {.hasMatrix = true, .matrix = node.local};  // edits move its instances, not the node
  RigNode rigged = decomposeTransform(node.local);
  rigged.hasMatrix = !(decompositionError(rigged) <= kRoundingOfDoubles);
  return rigged;
}

// Extends the rig to all nodes of the scene. Those that it did not cover, and their instances, stay where they are.
void coverNodes(Scene& scene) {
  if (!scene.yUp)
    badUsage("{} has Z up: only scenes in glTF's frame, with Y up, can have added or moved nodes and animations",
             scene.source);
  Rig& rig = scene.rig;
  const size_t first = rig.sceneNodes.size();
  if (first == scene.nodes.size()) return;
  // Nothing below allocates: nodes of the rig that lack an entry in another list would be invalid.
  for (std::vector<uint32_t>* list : {&rig.sceneNodes, &rig.order}) reserveMore(*list, scene.nodes.size() - first);
  reserveMore(rig.nodes, scene.nodes.size() - first);
  for (size_t i = first; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    RigNode rigged = uncoveredNode(scene, i);
    if (node.parent >= 0) rigged.parent = static_cast<int>(rig.sceneNodes[static_cast<size_t>(node.parent)]);
    rig.sceneNodes.push_back(static_cast<uint32_t>(rig.nodes.size()));
    rig.order.push_back(rig.sceneNodes.back());
    rig.nodes.push_back(std::move(rigged));
  }
  scene.fileNodes = {};
}

// --- nodes ----------------------------------------------------------------------------------------------------------

size_t targetsOf(const Scene& scene, const NewNode& added) {
  size_t count = 0;
  for (const NodePart& part : added.parts)
    if (const auto& deformation = scene.meshes[part.mesh].deformation)
      count = std::max(count, deformation->targets.size());
  return count;
}

void checkTransform(const RigNode& node, const dmat4& world, const std::string& owner) {
  const mat4 rounded(world);
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(rounded[i / 4][i % 4])) badUsage("{} has a transform that is not finite", owner);
  const double length = glm::length(node.rotation);
  if (!(length > 0)) badUsage("the rotation of {} must be a quaternion of a length above 0", owner);
  if (node.hasMatrix && glm::row(node.matrix, 3) != glm::dvec4(0, 0, 0, 1))
    badUsage("the matrix of {} must have the last row 0 0 0 1", owner);
}

void checkParts(Scene& scene, const NewNode& added, const std::string& owner) {
  for (const NodePart& part : added.parts) {
    const Mesh& mesh = present(scene.meshes, part.mesh, "mesh");
    present(scene.materials, part.material, "material");
    if (mesh.deformation && mesh.deformation->weightsNode >= 0)
      badUsage("the mesh \"{}\" already has the weights of another node: add it again for {}", printable(mesh.name),
               owner);
  }
  const std::vector<float>& weights = added.transform.weights;
  const size_t targets = targetsOf(scene, added);
  if (!weights.empty() && weights.size() != targets)
    badUsage("{} has {} weights, but its meshes have {} morph targets", owner, weights.size(), targets);
  if (!std::ranges::all_of(weights, [](float w) { return std::isfinite(w); }))
    badUsage("{} has a weight that is not finite", owner);
}

// The deformation with the weights of a node.
std::shared_ptr<const Deformation> weightedBy(uint32_t rigNode, const Deformation& deformation) {
  auto weighted = std::make_shared<Deformation>(deformation);
  weighted->weightsNode = static_cast<int>(rigNode);
  return weighted;
}

// Returns the meshes of the node's parts that have morph targets, with the node's weights, by their indices.
std::map<uint32_t, Mesh> weightedMeshes(const Scene& scene, const NewNode& added, uint32_t rigNode) {
  std::map<uint32_t, Mesh> meshes;
  for (const NodePart& part : added.parts) {
    const auto& deformation = scene.meshes[part.mesh].deformation;
    if (!deformation || deformation->targets.empty() || meshes.contains(part.mesh)) continue;
    Mesh& mesh = meshes[part.mesh] = scene.meshes[part.mesh];
    mesh.deformation = weightedBy(rigNode, *deformation);
    poseAtRest(scene, mesh);
    findBounds(mesh);
  }
  return meshes;
}

// Instances of skinned meshes are in the file's frame, because joints move them.
dmat4 placeOf(const Scene& scene, uint32_t node, uint32_t mesh) {
  const auto& deformation = scene.meshes[mesh].deformation;
  if (!deformation || deformation->skin < 0) return scene.nodes[node].toWorld;
  return toWorldFromGltf() * glm::translate(dmat4(1), scene.rig.skins[static_cast<size_t>(deformation->skin)].origin);
}

// Requires capacity for the instances.
void addParts(Scene& scene, const NewNode& added, uint32_t node, const std::vector<uint32_t>& partIds) {
  const bool isHidden = isHiddenAtRest(scene, node);
  for (uint32_t i = 0; i < added.parts.size(); ++i) {
    const NodePart& part = added.parts[i];
    const auto& deformation = scene.meshes[part.mesh].deformation;
    Instance instance{.mesh = part.mesh, .material = part.material, .node = node, .primitive = i};
    instance.id = scene.nodes[node].id;
    instance.part = partIds[i];
    instance.posed = deformation && deformation->skin >= 0;
    instance.hidden = isHidden;
    instance.toWorld = placeOf(scene, node, part.mesh);
    const uint32_t index = placeInstance(scene, instance);
    scene.edits.instances.note(index);
  }
}

// Appends a node to the scene and to the rig, and removes it again unless keep() is called.
class AppendedNode {
 public:
  AppendedNode(Scene& scene, Node node, RigNode rigged) : scene_(scene) {
    Rig& rig = scene.rig;
    for (std::vector<uint32_t>* list : {&rig.sceneNodes, &rig.order}) reserveMore(*list, 1);
    reserveMore(rig.nodes, 1);
    reserveMore(scene.nodes, 1);
    rig.sceneNodes.push_back(static_cast<uint32_t>(rig.nodes.size()));
    rig.order.push_back(rig.sceneNodes.back());
    rig.nodes.push_back(std::move(rigged));
    scene.nodes.push_back(std::move(node));
  }
  ~AppendedNode() {
    if (isKept_) return;
    scene_.rig.sceneNodes.pop_back();
    scene_.rig.order.pop_back();
    scene_.rig.nodes.pop_back();
    scene_.nodes.pop_back();
  }
  AppendedNode(const AppendedNode&) = delete;
  AppendedNode& operator=(const AppendedNode&) = delete;
  void keep() { isKept_ = true; }

 private:
  Scene& scene_;
  bool isKept_ = false;
};

}  // namespace

bool isHiddenAtRest(const Scene& scene, uint32_t node) {
  const Rig& rig = scene.rig;
  for (int i = static_cast<int>(rig.sceneNodes[node]); i >= 0; i = rig.nodes[static_cast<size_t>(i)].parent)
    if (!rig.nodes[static_cast<size_t>(i)].visible) return true;
  return false;
}

uint32_t rigNodeOf(Scene& scene, uint32_t node) {
  coverNodes(scene);
  if (node >= scene.nodes.size()) badUsage("there is no node {}: the scene has {}", node, scene.nodes.size());
  return scene.rig.sceneNodes[node];
}

uint32_t addNode(Scene& scene, const NewNode& added) {
  const std::string name = added.name.empty() ? "node" : added.name;
  checkName(name);
  const std::string owner = fmt::format("the node \"{}\"", printable(name));
  const RigNode& from = added.transform;
  const bool isRoot = added.parent < 0;
  if (!isRoot && static_cast<size_t>(added.parent) >= scene.nodes.size())
    badUsage("there is no node {}: the scene has {}", added.parent, scene.nodes.size());
  const dmat4 local = from.hasMatrix ? from.matrix : composeTransform(from.translation, from.rotation, from.scale);
  const Node* parent = isRoot ? nullptr : &scene.nodes[static_cast<size_t>(added.parent)];
  const dmat4 toWorld = (parent ? parent->toWorld : toWorldFromGltf()) * local;
  checkTransform(from, toWorld, owner);
  checkParts(scene, added, owner);
  coverNodes(scene);

  NewIds ids(scene);
  ids.make((parent ? parent->path : std::string()) + "/" + name, added.parts.size());
  Node node{.name = name, .path = ids.path, .mesh = added.parts.empty() ? "" : scene.meshes[added.parts[0].mesh].name};
  node.id = ids.id;
  node.parent = added.parent;
  node.local = local;
  node.toWorld = toWorld;
  RigNode rigged = from;
  rigged.parent = isRoot ? -1 : static_cast<int>(scene.rig.sceneNodes[static_cast<size_t>(added.parent)]);
  rigged.rotation = glm::normalize(from.rotation);
  rigged.weights.resize(targetsOf(scene, added));
  const auto index = static_cast<uint32_t>(scene.nodes.size()), rigNode = static_cast<uint32_t>(scene.rig.nodes.size());
  AppendedNode appended(scene, std::move(node), std::move(rigged));
  std::map<uint32_t, Mesh> weighted = weightedMeshes(scene, added, rigNode);
  scene.edits.meshes.reserve(scene.meshes.size(), weighted.size());
  reserveSlots(scene.instances, scene.edits.instanceGaps, scene.edits.instances, added.parts.size());

  ids.keep();
  appended.keep();
  if (!isRoot) scene.nodes[static_cast<size_t>(added.parent)].followed = true;
  for (auto& [mesh, data] : weighted) {
    scene.meshes[mesh] = std::move(data);
    scene.edits.meshes.note(mesh);
  }
  addParts(scene, added, index, ids.parts);
  return index;
}

// --- moved nodes ----------------------------------------------------------------------------------------------------

namespace {

bool isAnimated(const Rig& rig, uint32_t node) {
  const auto moves = [node](const Track& track) {
    return track.node == node && track.property <= AnimatedProperty::Scale;
  };
  return std::ranges::any_of(rig.animations, [&](const Animation& a) { return std::ranges::any_of(a.tracks, moves); });
}

// `from` with another transform.
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

// Poses a skinned mesh by joints that were moved.
void poseByJoints(const Scene& scene, const Pose& rest, Mesh& mesh) {
  const auto joints = jointMatrices(scene.rig.skins[static_cast<size_t>(mesh.deformation->skin)], rest);
  if (isMirrored(reachOf(*mesh.deformation), joints) != mesh.deformation->mirroredAtRest) {
    auto turned = std::make_shared<Deformation>(*mesh.deformation);
    turned->mirroredAtRest = !turned->mirroredAtRest;
    mesh.deformation = std::move(turned);
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  }
  poseAtRest(scene, mesh);
  findBounds(mesh);
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
  checkTransform({.hasMatrix = true, .matrix = parentFromNode}, parentFromNode, owner);
  std::vector<bool> isMoved(scene.rig.nodes.size());
  const Pose rest = restWith(scene, rigNode, withTransform(scene.rig, rigNode, parentFromNode, owner), owner);
  scene.nodes[node].local = parentFromNode;
  isMoved[rigNode] = true;
  for (const uint32_t index : scene.rig.order)
    if (const int parent = scene.rig.nodes[index].parent; parent >= 0 && isMoved[static_cast<size_t>(parent)])
      isMoved[index] = true;
  moveFollowers(scene, rest, isMoved);
}

// --- skins ----------------------------------------------------------------------------------------------------------

uint32_t addSkin(Scene& scene, std::span<const uint32_t> joints, std::vector<mat4> inverseBind) {
  if (joints.empty()) badUsage("a skin must have a joint");
  if (inverseBind.size() != joints.size())
    badUsage("a skin has {} joints but {} inverse bind matrices: the numbers must match", joints.size(),
             inverseBind.size());
  for (const mat4& m : inverseBind) {
    for (int i = 0; i < 16; ++i)
      if (!std::isfinite(m[i / 4][i % 4])) badUsage("an inverse bind matrix of a skin has a number that is not finite");
    if (glm::row(m, 3) != vec4(0, 0, 0, 1)) badUsage("an inverse bind matrix must have the last row 0 0 0 1");
  }
  coverNodes(scene);
  reserveMore(scene.rig.skins, 1);
  Skin skin{.inverseBind = std::move(inverseBind)};
  dvec3 mean(0);
  for (const uint32_t joint : joints) {
    skin.joints.push_back(scene.rig.sceneNodes.at(joint));
    scene.nodes[joint].followed = true;
    mean += dvec3((toGltfFromWorld() * scene.nodes[joint].toWorld)[3]) / double(joints.size());
  }
  skin.origin = originNear(mean);
  scene.rig.skins.push_back(std::move(skin));
  return static_cast<uint32_t>(scene.rig.skins.size() - 1);
}

void poseAtRest(const Scene& scene, Mesh& mesh) {
  const Deformation& d = *mesh.deformation;
  const Pose rest = restPose(scene);
  std::vector<mat4> joints;
  if (d.skin >= 0) joints = jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], rest);
  std::vector<float> weights;
  if (d.weightsNode >= 0) weights = rest.weights[static_cast<size_t>(d.weightsNode)];
  DeformedVertices posed = deform(d, joints, weights);
  mesh.positions = std::move(posed.positions);
  mesh.attributes = std::move(posed.attributes);
}

// --- animations -----------------------------------------------------------------------------------------------------

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
