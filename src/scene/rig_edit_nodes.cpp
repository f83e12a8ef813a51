// Extends the rig to all nodes of a scene, and adds nodes; see scene/rig_edit.h.
#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/reserve.h"
#include "scene/decompose.h"
#include "scene/edit_check.h"
#include "scene/edit_slots.h"
#include "scene/rig_edit.h"
#include "scene/rig_edit_steps.h"

namespace latelight::scene {

namespace {

// Allocates memory for more nodes of the rig, so that appendNode() does not: a node of the rig that lacks an entry in
// another list would be invalid.
void reserveNodes(Rig& rig, size_t count) {
  for (std::vector<uint32_t>* list : {&rig.sceneNodes, &rig.order}) reserveMore(*list, count);
  reserveMore(rig.nodes, count);
}

// Appends the next node of the scene.
void appendNode(Rig& rig, RigNode node) {
  rig.sceneNodes.push_back(static_cast<uint32_t>(rig.nodes.size()));
  rig.order.push_back(rig.sceneNodes.back());
  rig.nodes.push_back(std::move(node));
}

void removeLastNode(Rig& rig) {
  rig.sceneNodes.pop_back();
  rig.order.pop_back();
  rig.nodes.pop_back();
}

// A node that the rig does not cover yet, except for its parent.
RigNode uncoveredNode(Scene& scene, size_t index) {
  if (index < scene.fileNodes.size()) return std::move(scene.fileNodes[index]);
  const Node& node = scene.nodes[index];
  if (node.added > 0) return {.hasMatrix = true, .matrix = node.local};  // edits move its instances, not the node
  RigNode rigged = decomposeTransform(node.local);
  rigged.hasMatrix = !(decompositionError(rigged) <= kRoundingOfDoubles);
  return rigged;
}

size_t targetsOf(const Scene& scene, const NewNode& added) {
  size_t count = 0;
  for (const NodePart& part : added.parts)
    if (const auto& deformation = scene.meshes[part.mesh].deformation)
      count = std::max(count, deformation->targets.size());
  return count;
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
    reserveNodes(scene.rig, 1);
    reserveMore(scene.nodes, 1);
    appendNode(scene.rig, std::move(rigged));
    scene.nodes.push_back(std::move(node));
  }
  ~AppendedNode() {
    if (isKept_) return;
    removeLastNode(scene_.rig);
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

void coverNodes(Scene& scene) {
  if (!scene.yUp)
    badUsage("{} has Z up: only scenes in glTF's frame, with Y up, can have added or moved nodes and animations",
             scene.source);
  Rig& rig = scene.rig;
  const size_t first = rig.sceneNodes.size();
  if (first == scene.nodes.size()) return;
  reserveNodes(rig, scene.nodes.size() - first);
  for (size_t i = first; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    RigNode rigged = uncoveredNode(scene, i);
    if (node.parent >= 0) rigged.parent = static_cast<int>(rig.sceneNodes[static_cast<size_t>(node.parent)]);
    appendNode(rig, std::move(rigged));
  }
  scene.fileNodes = {};
}

void checkNodeTransform(const RigNode& node, const dmat4& world, const std::string& owner) {
  const mat4 rounded(world);
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(rounded[i / 4][i % 4])) badUsage("{} has a transform that is not finite", owner);
  const double length = glm::length(node.rotation);
  if (!(length > 0)) badUsage("the rotation of {} must be a quaternion of a length above 0", owner);
  if (node.hasMatrix && glm::row(node.matrix, 3) != glm::dvec4(0, 0, 0, 1))
    badUsage("the matrix of {} must have the last row 0 0 0 1", owner);
}

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
  checkNodeTransform(from, toWorld, owner);
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

}  // namespace latelight::scene
