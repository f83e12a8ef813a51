#include "scene/bake.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "scene/decompose.h"

namespace latelight::scene {

namespace {

void bakeInstances(Scene& scene, const Pose& pose) {
  const std::vector<dmat4> transforms = instanceTransforms(scene, pose);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    Instance& instance = scene.instances[i];
    instance.removed = !isShown(scene, pose, instance);
    instance.hidden = false;
    instance.toWorld = transforms[i];
  }
}

void bakeValues(Scene& scene, const Pose& pose) {
  scene.lights = posedLights(scene, pose);
  for (Light& light : scene.lights) light.hidden = false;
  for (const auto& [index, material] : posedMaterials(scene, pose)) scene.materials[index].data = material;
}

// The vertices at rest, which formats without skins hold.
void bakeVertices(Scene& scene, const Pose& pose) {
  if (pose.empty()) return;
  for (Mesh& mesh : scene.meshes) {
    if (mesh.removed || !mesh.deformation) continue;
    const Deformation& d = *mesh.deformation;
    std::vector<glm::mat4> joints;
    std::vector<float> weights;
    if (d.skin >= 0) joints = jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], pose);
    if (d.weightsNode >= 0) weights = pose.weights[static_cast<size_t>(d.weightsNode)];
    DeformedVertices vertices = deform(d, joints, weights);
    mesh.positions = std::move(vertices.positions);
    mesh.attributes = std::move(vertices.attributes);
    findBounds(mesh);
  }
}

// The common transform of a node's instances if edits have placed all of them, by node.
std::vector<std::optional<dmat4>> placedNodes(const Scene& scene) {
  std::vector<std::optional<dmat4>> placed(scene.nodes.size());
  std::vector<uint8_t> mixed(scene.nodes.size());
  for (const Instance& instance : scene.instances) {
    if (instance.removed) continue;
    std::optional<dmat4>& place = placed[instance.node];
    const bool isAlone = !instance.placed || instance.posed || instance.copy >= 0;
    mixed[instance.node] |= isAlone || (place && *place != instance.toWorld);
    place = instance.toWorld;
  }
  for (size_t i = 0; i < placed.size(); ++i)
    if (mixed[i]) placed[i].reset();
  return placed;
}

std::vector<bool> nodesWithInstances(const Scene& scene) {
  std::vector<bool> with(scene.nodes.size());
  for (const Instance& instance : scene.instances)
    if (!instance.removed) with[instance.node] = true;
  return with;
}

// The nodes of the rig that are joints, or that joints follow.
std::vector<bool> nodesOfSkins(const Rig& rig) {
  std::vector<bool> nodes(rig.nodes.size());
  for (const Skin& skin : rig.skins)
    for (const uint32_t joint : skin.joints)
      for (int i = static_cast<int>(joint); i >= 0 && !nodes[static_cast<size_t>(i)];
           i = rig.nodes[static_cast<size_t>(i)].parent)
        nodes[static_cast<size_t>(i)] = true;
  return nodes;
}

// Moves the nodes without instances. Joints stay, because they would move their skins.
void placeNodes(Scene& scene, Pose& pose, const std::map<uint32_t, dmat4>& nodes) {
  const std::vector<bool> withInstances = nodesWithInstances(scene), ofSkins = nodesOfSkins(scene.rig);
  for (const auto& [node, toWorld] : nodes) {
    if (withInstances[node]) continue;
    if (node >= scene.rig.sceneNodes.size())
      scene.nodes[node].toWorld = toWorld;
    else if (!ofSkins[scene.rig.sceneNodes[node]])
      pose.world[scene.rig.sceneNodes[node]] = toGltfFromWorld() * toWorld;
  }
}

// Gives each node of the rig the local transform that leads to its transform in the world, unless it has that.
void setLocals(Rig& rig, const std::vector<dmat4>& world) {
  for (const uint32_t i : rig.order) {
    RigNode& node = rig.nodes[i];
    const dmat4 parent = node.parent < 0 ? dmat4(1) : world[static_cast<size_t>(node.parent)];
    const dmat4 local = node.hasMatrix ? node.matrix : composeTransform(node.translation, node.rotation, node.scale);
    if (parent * local == world[i] || glm::determinant(parent) == 0) continue;
    const RigNode baked =
        nodeWithTransform(glm::inverse(parent) * world[i], node.hasMatrix ? dvec3(1) : signsOf(node.scale));
    node.hasMatrix = baked.hasMatrix;
    node.matrix = baked.matrix;
    node.translation = baked.translation;
    node.rotation = baked.rotation;
    node.scale = baked.scale;
  }
}

// `at`: the pose to which nodes without instances have been moved.
void bakeRig(Scene& scene, Pose at) {
  Rig& rig = scene.rig;
  const std::vector<std::optional<dmat4>> placed = placedNodes(scene);
  for (size_t i = 0; i < rig.sceneNodes.size(); ++i) {
    dmat4& world = at.world[rig.sceneNodes[i]];
    if (placed[i]) world = toGltfFromWorld() * *placed[i];
    scene.nodes[i].toWorld = toWorldFromGltf() * world;
  }
  for (Instance& instance : scene.instances)
    if (instance.node < rig.sceneNodes.size() && placed[instance.node]) instance.placed = false;
  setLocals(rig, at.world);
  for (size_t i = 0; i < rig.nodes.size(); ++i) {
    rig.nodes[i].weights = at.weights[i];
    rig.nodes[i].visible = true;
  }
  rig.animations.clear();
  rig.materials.clear();
  const auto deforms = [](const Mesh& mesh) { return !mesh.removed && mesh.deformation; };
  if (!rig.skins.empty() || std::ranges::any_of(scene.meshes, deforms)) return;
  for (const uint32_t node : rig.sceneNodes) scene.fileNodes.push_back(std::move(rig.nodes[node]));
  rig = {};
}

}  // namespace

void bakePose(Scene& scene, const Pose& pose, const std::map<uint32_t, dmat4>& nodes) {
  bakeInstances(scene, pose);
  bakeValues(scene, pose);
  bakeVertices(scene, pose);
  Pose at = pose.empty() && !scene.rig.empty() ? restPose(scene) : pose;
  placeNodes(scene, at, nodes);
  if (!scene.rig.empty()) bakeRig(scene, std::move(at));
}

}  // namespace latelight::scene
