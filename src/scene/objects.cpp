#include "scene/objects.h"

#include <algorithm>
#include <map>

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

}  // namespace

dmat4 rigidOf(const dmat4& m) {
  dvec3 x(m[0]), y(m[1]);
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

dmat4 objectToWorld(const Scene& scene, const Pose& pose, std::span<const dmat4> toWorld,
                    std::span<const uint32_t> instances) {
  const Instance& first = scene.instances[instances.front()];
  const bool one = std::ranges::all_of(instances, [&](uint32_t i) {
    return scene.instances[i].node == first.node && scene.instances[i].copy == first.copy;
  });
  return one ? toWorld[instances.front()] : nodeToWorld(scene, pose, topmost(scene, first.node));
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
  std::vector<RestFrame> frames(scene.instances.size());
  for (const auto& [id, instances] : objects) {
    const dmat4 objectFromWorld = glm::inverse(rigidOf(objectToWorld(scene, {}, toWorld, instances)));
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
