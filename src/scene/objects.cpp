#include "scene/objects.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "scene/decompose.h"

namespace latelight::scene {

namespace {

// Returns true if the transform maps axis-aligned boxes to axis-aligned boxes of the same axes, up to rounding.
bool keepsAxes(const dmat4& m) {
  double across = 0, along = 0;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      (column == row ? along : across) = std::max(column == row ? along : across, std::abs(m[column][row]));
  return across <= 1e-6 * along;
}

uint32_t topmost(const Scene& scene, uint32_t node) {
  const std::vector<Node>& nodes = scene.nodes;
  while (nodes[node].parent >= 0 && nodes[static_cast<size_t>(nodes[node].parent)].id == nodes[node].id)
    node = static_cast<uint32_t>(nodes[node].parent);
  return node;
}

// The mesh of a posed instance may have been replaced by one without joints.
dvec3 skinOrigin(const Scene& scene, const Instance& instance) {
  const auto& deformation = scene.meshes[instance.mesh].deformation;
  if (!deformation || deformation->skin < 0) return dvec3(0);
  return scene.rig.skins[static_cast<size_t>(deformation->skin)].origin;
}

// Returns the world transform that an instance has before edits and worlds move it.
dmat4 unplacedToWorld(const Scene& scene, const Pose& pose, uint32_t instance) {
  const Instance& i = scene.instances[instance];
  return !i.placed && pose.empty() ? i.toWorld : followedToWorld(scene, pose, instance);
}

// Returns true if two affine transforms are equal up to the rounding of floats. `reach`: the largest coordinates, whose
// rounding the translations contain.
bool isNear(const dmat4& a, const dmat4& b, double reach) {
  constexpr double kRounding = 1e-5;
  double largest = 0, linear = 0, translation = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      largest = std::max(largest, std::abs(b[column][row]));
      linear = std::max(linear, std::abs(a[column][row] - b[column][row]));
    }
    translation = std::max(translation, std::abs(a[3][row] - b[3][row]));
  }
  return linear <= kRounding * largest && translation <= kRounding * reach;
}

double reachOf(const dmat4& m) {
  return glm::length(dvec3(m[3]));
}

// Negative if the transform mirrors. The determinant of a flat transform has no sign, because it is 0 up to rounding.
double handednessOf(const dmat4& m) {
  constexpr double kFlat = 1e-12;
  const double lengths = glm::length(dvec3(m[0])) * glm::length(dvec3(m[1])) * glm::length(dvec3(m[2]));
  const double determinant = glm::determinant(glm::dmat3(m));
  return std::abs(determinant) > kFlat * lengths ? determinant : 0;
}

constexpr dvec3 kMirrored(-1, 1, 1);  // for matrices, which do not state which axis they mirror

// The node as its file or an edit states it; null if only its matrix is known.
const RigNode* statedNode(const Scene& scene, uint32_t node) {
  if (node < scene.rig.sceneNodes.size()) return &scene.rig.nodes[scene.rig.sceneNodes[node]];
  return node < scene.fileNodes.size() ? &scene.fileNodes[node] : nullptr;
}

dvec3 scaleSignsOf(const Scene& scene, uint32_t node) {
  const RigNode* stated = statedNode(scene, node);
  if (stated && !stated->hasMatrix) return signsOf(stated->scale);
  return handednessOf(stated ? stated->matrix : scene.nodes[node].local) < 0 ? kMirrored : dvec3(1);
}

// Returns the signs of the scales of a node and of those above it, multiplied.
dvec3 scaleSignsFrom(const Scene& scene, uint32_t node) {
  dvec3 signs(1);
  for (int i = static_cast<int>(node); i >= 0; i = scene.nodes[static_cast<size_t>(i)].parent)
    signs *= nodeScaleSigns(scene, static_cast<uint32_t>(i));
  return signs;
}

}  // namespace

dvec3 nodeScaleSigns(const Scene& scene, uint32_t node) {
  const auto copy = scene.nodeCopies.find(node);
  return copy != scene.nodeCopies.end() ? copy->second.scaleSigns : scaleSignsOf(scene, node);
}

dvec3 copyScaleSigns(const Scene& scene, uint32_t instance) {
  const Instance& i = scene.instances[instance];
  if (i.copy < 0) return dvec3(1);
  return signsOf(statedTransform(scene.fileCopies.at(i.node), static_cast<size_t>(i.copy)).scale);
}

dvec3 instanceScaleSigns(const Scene& scene, uint32_t instance) {
  const Instance& i = scene.instances[instance];
  const dvec3 signs = copyScaleSigns(scene, instance);
  return i.posed ? signs : scaleSignsFrom(scene, i.node) * signs;
}

dmat4 rigidOf(const dmat4& m, dvec3 scaleSigns) {
  const double handedness = handednessOf(m);
  // An edit, a copy or an animation may mirror the object in another way than its nodes.
  if (handedness * scaleSigns.x * scaleSigns.y * scaleSigns.z < 0) scaleSigns = handedness < 0 ? kMirrored : dvec3(1);
  dvec3 x(dvec3(m[0]) * scaleSigns.x), y(dvec3(m[1]) * scaleSigns.y);
  if (!(glm::length(x) > 0)) x = {1, 0, 0};
  x = glm::normalize(x);
  y -= glm::dot(x, y) * x;
  if (!(glm::length(y) > 0)) y = glm::cross(std::abs(x.z) < 0.5 ? dvec3(0, 0, 1) : dvec3(0, 1, 0), x);
  y = glm::normalize(y);
  return {glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(glm::cross(x, y), 0), glm::dvec4(dvec3(m[3]), 1)};
}

dmat4 nodeToWorld(const Scene& scene, const Pose& pose, uint32_t node) {
  if (pose.empty() || node >= scene.rig.sceneNodes.size()) return scene.nodes[node].toWorld;
  return toWorldFromGltf() * pose.world[scene.rig.sceneNodes[node]];
}

dmat4 followedToWorld(const Scene& scene, const Pose& pose, uint32_t instance) {
  const Instance& followed = scene.instances[instance];
  dmat4 toWorld = followed.posed ? toWorldFromGltf() : nodeToWorld(scene, pose, followed.node);
  if (followed.copy >= 0)
    toWorld = toWorld * nodeFromCopy(scene.fileCopies.at(followed.node), static_cast<size_t>(followed.copy));
  return followed.posed ? glm::translate(toWorld, skinOrigin(scene, followed)) : toWorld;
}

std::optional<dmat4> commonDisplacement(const Scene& scene, const Pose& pose, std::span<const dmat4> toWorld,
                                        std::span<const uint32_t> instances) {
  std::optional<dmat4> displacement;
  double firstReach = 0;
  for (const uint32_t i : instances) {
    const dmat4 unplaced = unplacedToWorld(scene, pose, i);
    if (!displacement) {
      displacement = toWorld[i] == unplaced ? dmat4(1) : toWorld[i] * glm::inverse(unplaced);
      firstReach = reachOf(toWorld[i]) + reachOf(unplaced);
    }
    const double reach = firstReach + reachOf(toWorld[i]) + reachOf(unplaced);
    if (!isNear(*displacement * unplaced, toWorld[i], reach)) return std::nullopt;
  }
  return displacement;
}

ObjectFrames::ObjectFrames(const Scene& scene) : scene_(scene), hasChildInGroup_(scene.nodes.size()) {
  for (const Node& child : scene.nodes) {
    if (child.parent < 0) continue;
    const auto parent = static_cast<size_t>(child.parent);
    if (child.id == scene.nodes[parent].id) hasChildInGroup_[parent] = true;
  }
}

// Returns true if the object is a group of nodes, or of all copies of a node. That is determined by ids, because a
// group may show only one of its instances. An instance at the topmost node of a group has its frame by itself, unless
// joints move it.
bool ObjectFrames::isGroup(std::span<const uint32_t> instances) const {
  return std::ranges::any_of(instances, [&](uint32_t i) {
    const Instance& instance = scene_.instances[i];
    const bool isCopyInGroup = instance.copy >= 0 && instance.id == scene_.nodes[instance.node].id;
    return isCopyInGroup || topmost(scene_, instance.node) != instance.node ||
           (instance.posed && hasChildInGroup_[instance.node]);
  });
}

dmat4 ObjectFrames::toWorld(const Pose& pose, std::span<const dmat4> toWorld,
                            std::span<const uint32_t> instances) const {
  if (!isGroup(instances)) return toWorld[instances.front()];
  const Instance& first = scene_.instances[instances.front()];
  const dmat4 displacement = commonDisplacement(scene_, pose, toWorld, instances).value_or(dmat4(1));
  return displacement * nodeToWorld(scene_, pose, topmost(scene_, first.node));
}

dvec3 ObjectFrames::scaleSigns(std::span<const uint32_t> instances) const {
  if (!isGroup(instances)) return instanceScaleSigns(scene_, instances.front());
  return scaleSignsFrom(scene_, topmost(scene_, scene_.instances[instances.front()].node));
}

void addMesh(Extent& extent, const Mesh& mesh, const dmat4& transform) {
  if (mesh.positions.empty()) return;
  const auto add = [&](vec3 point) { extent.add(dvec3(transform * glm::dvec4(point, 1))); };
  if (keepsAxes(transform)) {
    add(mesh.boundsMin);
    add(mesh.boundsMax);
  } else {
    std::ranges::for_each(mesh.positions, add);
  }
}

std::vector<RestFrame> restFrames(const Scene& scene) {
  std::map<uint32_t, std::vector<uint32_t>> objects;  // instances by id
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (!scene.instances[i].removed) objects[scene.instances[i].id].push_back(i);
  const std::vector<dmat4> toWorld = instanceTransforms(scene, {});
  const ObjectFrames objectFrames(scene);
  std::vector<RestFrame> frames(scene.instances.size());
  for (const auto& [id, instances] : objects) {
    const dmat4 objectFromWorld =
        glm::inverse(rigidOf(objectFrames.toWorld({}, toWorld, instances), objectFrames.scaleSigns(instances)));
    Extent box;
    for (const uint32_t i : instances) {
      frames[i].objectFromMesh = objectFromWorld * toWorld[i];
      addMesh(box, scene.meshes[scene.instances[i].mesh], frames[i].objectFromMesh);
    }
    for (const uint32_t i : instances) frames[i].box = box;
  }
  return frames;
}

}  // namespace latelight::scene
