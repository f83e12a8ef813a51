// The public API's nodes, skins, morph targets and animations: converts those of latelight.h to those of
// scene/rig_edit.h.
#include <algorithm>
#include <cmath>
#include <new>

#include "api/scene.h"
#include "api/transform.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/reserve.h"
#include "scene/edit.h"
#include "scene/rig_edit.h"

namespace latelight {

namespace {

using glm::mat4;
using glm::vec3;

// --- deformations ---------------------------------------------------------------------------------------------------

// Deltas for the vertices of a mesh, of which several may follow from one position.
std::vector<vec3> deltasOf(const std::vector<std::array<float, 3>>& from, const scene::VertexSources& sources,
                           const MeshData& mesh, const char* what) {
  std::vector<vec3> deltas;
  if (from.empty()) return deltas;
  if (from.size() != mesh.positions.size())
    badUsage("the mesh \"{}\" has {} positions but a morph target with {} {}: the numbers must match",
             printable(mesh.name), mesh.positions.size(), from.size(), what);
  for (const std::array<float, 3>& delta : from)
    for (const float number : delta)
      if (!std::isfinite(number))
        badUsage("the {} of a morph target of the mesh \"{}\" must be finite", what, printable(mesh.name));
  deltas.reserve(sources.origin.size());
  for (const uint32_t i : sources.origin) deltas.emplace_back(from[i][0], from[i][1], from[i][2]);
  return deltas;
}

scene::MorphTarget targetOf(const MorphTarget& from, const scene::VertexSources& sources, const MeshData& mesh) {
  if ((mesh.normals.empty() && !from.normals.empty()) || (mesh.tangents.empty() && !from.tangents.empty()))
    badUsage("a morph target of the mesh \"{}\" changes {}, which the mesh does not have", printable(mesh.name),
             mesh.normals.empty() && !from.normals.empty() ? "normals" : "tangents");
  scene::MorphTarget target{deltasOf(from.positions, sources, mesh, "positions"),
                            deltasOf(from.normals, sources, mesh, "normals"),
                            deltasOf(from.tangents, sources, mesh, "tangents")};
  for (size_t i = 0; i < target.normals.size() && !sources.turned.empty(); ++i)
    if (sources.turned[sources.origin[i]]) target.normals[i] = -target.normals[i];
  return target;
}

// Checks the influences of a mesh, and returns how many each vertex has.
size_t influencesOf(const MeshData& mesh, size_t joints) {
  const size_t vertices = mesh.positions.size(), all = mesh.joints.size();
  if (all != mesh.jointWeights.size())
    badUsage("the mesh \"{}\" has {} joints but {} joint weights: the numbers must match", printable(mesh.name), all,
             mesh.jointWeights.size());
  if (all == 0 || all % vertices != 0)
    badUsage("the mesh \"{}\" has {} joints for {} positions: each must have the same number, at least one",
             printable(mesh.name), all, vertices);
  const size_t each = all / vertices;
  for (size_t vertex = 0; vertex < vertices; ++vertex) {
    double sum = 0;
    for (size_t i = vertex * each; i < (vertex + 1) * each; ++i) {
      const float weight = mesh.jointWeights[i];
      if (!(std::isfinite(weight) && weight >= 0))
        badUsage("the mesh \"{}\" has the joint weight {}: weights must be finite and at least 0", printable(mesh.name),
                 weight);
      if (weight > 0 && mesh.joints[i] >= joints)
        badUsage("the mesh \"{}\" has the joint {}, but its skin has {}", printable(mesh.name), mesh.joints[i], joints);
      sum += weight;
    }
    if (!(sum > 0)) badUsage("the joint weights of vertex {} of the mesh \"{}\" are 0", vertex, printable(mesh.name));
  }
  return each;
}

void addInfluences(const MeshData& from, const scene::VertexSources& sources, size_t joints, scene::Deformation& d) {
  const size_t each = influencesOf(from, joints);
  d.influences = static_cast<uint32_t>((each + 3) / 4 * 4);
  d.joints.assign(sources.origin.size() * d.influences, 0);
  d.jointWeights.assign(d.joints.size(), 0);
  for (size_t vertex = 0; vertex < sources.origin.size(); ++vertex) {
    const std::span<float> weights = std::span(d.jointWeights).subspan(vertex * d.influences, d.influences);
    for (size_t i = 0; i < each; ++i) {
      const size_t source = sources.origin[vertex] * each + i;
      weights[i] = from.jointWeights[source];
      if (weights[i] > 0) d.joints[vertex * d.influences + i] = from.joints[source];
    }
    scene::normalizeWeights(weights);
  }
}

// If the joints at rest mirror the mesh, the winding of its triangles is reversed, as when a glTF file is loaded.
void turnOverIfMirrored(const scene::Scene& scene, scene::Deformation& d, scene::Mesh& mesh) {
  const auto joints = scene::jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], scene::restPose(scene));
  d.mirroredAtRest = scene::isMirrored(scene::reachOf(d), joints);
  if (d.mirroredAtRest)
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
}

}  // namespace

void Scene::Impl::addDeformation(const MeshData& from, const scene::VertexSources& sources, int weightsNode,
                                 scene::Mesh& mesh) const {
  const size_t required = weightsNode < 0 ? 0 : scene.rig.nodes[static_cast<size_t>(weightsNode)].weights.size();
  if (weightsNode >= 0 && from.targets.size() > required)
    badUsage("the mesh \"{}\" has {} morph targets, but the node that shows it has {} weights", printable(mesh.name),
             from.targets.size(), required);
  if (!from.skin && !from.joints.empty())
    badUsage("the mesh \"{}\" has joints but no skin: add one to the scene", printable(from.name));
  if (!from.skin && from.targets.empty()) return;
  auto d = std::make_shared<scene::Deformation>();
  d->flatNormals = sources.flatNormals;
  d->positions = mesh.positions;
  d->attributes = mesh.attributes;
  for (const MorphTarget& target : from.targets) d->targets.push_back(targetOf(target, sources, from));
  if (!from.targets.empty()) d->weightsNode = weightsNode;
  if (from.skin) {
    const uint32_t skin = index(*from.skin);
    addInfluences(from, sources, scene.rig.skins[skin].joints.size(), *d);
    d->skin = static_cast<int>(skin);
    turnOverIfMirrored(scene, *d, mesh);
  }
  mesh.deformation = std::move(d);
  scene::poseAtRest(scene, mesh);
}

// --- nodes and skins ------------------------------------------------------------------------------------------------

std::string Scene::addNode(const NodeData& node) try {
  scene::NewNode added{.name = node.name, .parent = -1, .transform = {.hasMatrix = node.matrix.has_value()}};
  if (!node.parent.empty()) added.parent = static_cast<int>(filled().nodeAt(node.parent));
  if (node.matrix) added.transform.matrix = matrixOf(*node.matrix);
  for (int i = 0; i < 3; ++i) {
    added.transform.translation[i] = node.translation[static_cast<size_t>(i)];
    added.transform.scale[i] = node.scale[static_cast<size_t>(i)];
  }
  for (int i = 0; i < 4; ++i) added.transform.rotation[i] = node.rotation[static_cast<size_t>(i)];
  added.transform.weights = node.weights;
  for (const NodePart& part : node.parts)
    added.parts.push_back({filled().index(part.mesh), filled().index(part.material)});
  std::string path;  // allocated before the scene changes: with a slash, "node" if there is no name, and "#<number>"
  path.reserve(node.parent.size() + node.name.size() + 16);
  path = filled().scene.nodes[scene::addNode(filled().scene, added)].path;
  return path;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setNodeTransform(const std::string& node, const Transform& parentFromNode) try {
  scene::setNodeTransform(filled().scene, filled().nodeAt(node), matrixOf(parentFromNode));
  for (size_t i = 0; i < filled().cameras.size(); ++i)
    if (const scene::Camera& camera = filled().scene.cameras[i]; camera.node >= 0)
      filled().cameras[i] = filled().posedCamera(i, camera);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Skin> Scene::addSkin(const Skin& skin) try {
  std::vector<uint32_t> joints;
  for (const std::string& joint : skin.joints) joints.push_back(filled().nodeAt(joint));
  std::vector<mat4> inverseBind;
  for (const Transform& transform : skin.inverseBind) inverseBind.emplace_back(matrixOf(transform));
  if (skin.inverseBind.empty()) inverseBind.assign(joints.size(), mat4(1));
  return filled().skin(scene::addSkin(filled().scene, joints, std::move(inverseBind)));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- animations -----------------------------------------------------------------------------------------------------

void Scene::addAnimation(const std::string& name, const std::vector<AnimationChannel>& channels) try {
  constexpr scene::Interpolation kInterpolations[] = {scene::Interpolation::Step, scene::Interpolation::Linear,
                                                      scene::Interpolation::Cubic};
  constexpr scene::AnimatedProperty kProperties[] = {
      scene::AnimatedProperty::Translation, scene::AnimatedProperty::Rotation, scene::AnimatedProperty::Scale,
      scene::AnimatedProperty::Weights, scene::AnimatedProperty::Visible};
  scene::Animation animation{.name = name};
  Animation published{.name = name};
  for (const AnimationChannel& channel : channels) {
    const auto interpolation = static_cast<size_t>(channel.interpolation);
    const auto property = static_cast<size_t>(channel.property);
    if (interpolation >= std::size(kInterpolations) || property >= std::size(kProperties))
      badUsage("the animation \"{}\" has an unknown interpolation or property", printable(name));
    scene::Track track;
    track.interpolation = kInterpolations[interpolation];
    track.times = channel.times;
    track.values = channel.values;
    track.node = scene::rigNodeOf(filled().scene, filled().nodeAt(channel.node));
    track.property = kProperties[property];
    if (track.property == scene::AnimatedProperty::Visible)
      for (float& value : track.values) value = value != 0 ? 1.0f : 0.0f;
    animation.tracks.push_back(std::move(track));
  }
  reserveMore(filled().animations, 1);
  scene::addAnimation(filled().scene, std::move(animation));
  const scene::Animation& made = filled().scene.rig.animations.back();
  published.duration = made.duration;
  if (name.empty()) published.name = made.name;  // short names require no allocation
  filled().animations.push_back(std::move(published));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- lights that follow nodes ---------------------------------------------------------------------------------------

Handle<Light> Scene::addLight(const Light& values, const std::string& node) try {
  const uint32_t index = filled().nodeAt(node);
  scene::rigNodeOf(filled().scene, index);
  scene::Light light = internalLight(values, filled().scene);
  light.node = static_cast<int>(index);
  light.hidden = scene::isHiddenAtRest(filled().scene, index);
  scene::placeLight(light, scene::toGltfFromWorld() * filled().scene.nodes[index].toWorld);
  return filled().light(scene::addLight(filled().scene, light));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

}  // namespace latelight
