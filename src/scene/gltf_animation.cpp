// Animations and skins (glTF 2.0, 3.7.3 and 3.11), and the nodes in the form they need.
#include <algorithm>
#include <glm/gtc/matrix_access.hpp>
#include <optional>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf_accessor.h"
#include "scene/gltf_nodes.h"
#include "scene/gltf_skin.h"

namespace latelight::scene::gltf {
namespace {

using nlohmann::json;

Interpolation readInterpolation(const json& sampler, const std::string& name) {
  const std::string text = sampler.value("interpolation", std::string("LINEAR"));
  if (text == "STEP") return Interpolation::Step;
  if (text == "LINEAR") return Interpolation::Linear;
  if (text == "CUBICSPLINE") return Interpolation::Cubic;
  badInput("{} has the unknown interpolation \"{}\"", name, text);
}

// Nothing for targets that are not node properties: KHR_animation_pointer's.
std::optional<AnimatedProperty> readProperty(const json& target, const std::string& name) {
  const std::string path = target["path"].get<std::string>();
  if (path == "translation") return AnimatedProperty::Translation;
  if (path == "rotation") return AnimatedProperty::Rotation;
  if (path == "scale") return AnimatedProperty::Scale;
  if (path == "weights") return AnimatedProperty::Weights;
  if (path != "pointer") badInput("{} moves \"{}\", which no node has", name, path);
  warn("what the file animates by pointer (KHR_animation_pointer) stays as it is");
  return std::nullopt;
}

uint32_t weightCount(const Document& document, uint32_t node) {
  const int mesh = document.model.nodes[node].mesh;
  if (mesh < 0) return 0;
  return static_cast<uint32_t>(document.model.meshes[size_t(mesh)].primitives[0].targets.size());
}

std::vector<float> readTimes(const Document& document, int accessor, const std::string& name) {
  const Elements elements = resolve(document, accessor);
  if (elements.components != 1 || elements.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    badInput("{} has times that are not floats, in {}", name, elements.name);
  document.budget.charge(elements.count * sizeof(float), elements.name);
  std::vector<float> times;
  for (const glm::vec<1, float>& time : readFinite<1>(elements, 0, elements.count)) times.push_back(time.x);
  if (!std::is_sorted(times.begin(), times.end())) badInput("{} has times that fall, in {}", name, elements.name);
  if (times.front() < 0) badInput("{} has a time before 0, in {}", name, elements.name);
  return times;
}

// Integers are normalised whether or not the accessor says so: rotations and weights allow nothing else.
std::vector<float> readValues(const Document& document, int accessor, const Track& track, const std::string& name) {
  Elements elements = resolve(document, accessor);
  elements.normalized = true;
  const bool scalars = track.property == AnimatedProperty::Weights;
  const size_t each = scalars ? track.width : 1, keys = track.interpolation == Interpolation::Cubic ? 3 : 1;
  if (elements.components != (scalars ? 1 : track.width) || elements.count != track.times.size() * keys * each)
    badInput("{} has {} times, for which {} has the wrong number of values or components", name, track.times.size(),
             elements.name);
  document.budget.charge(elements.count * sizeof(glm::vec4) * 2, elements.name);
  std::vector<float> values;
  values.reserve(elements.count * elements.components);
  const auto append = [&](const auto& vectors) {
    for (const auto& v : vectors)
      for (int c = 0; c < v.length(); ++c) values.push_back(v[c]);
  };
  if (elements.components == 1) append(readFinite<1>(elements, 0, elements.count));
  if (elements.components == 3) append(readFinite<3>(elements, 0, elements.count));
  if (elements.components == 4) append(readFinite<4>(elements, 0, elements.count));
  return values;
}

std::optional<Track> readTrack(const Document& document, const json& animation, const json& channel,
                               const std::string& name) {
  const json& target = channel["target"];
  const std::optional<AnimatedProperty> property = readProperty(target, name);
  if (!property || !target.contains("node")) return std::nullopt;
  const size_t sampler = channel["sampler"].get<size_t>();
  if (sampler >= animation["samplers"].size())
    badInput("{}.sampler is {}, but there are {} samplers", name, sampler, animation["samplers"].size());
  const json& source = animation["samplers"][sampler];

  Track track{.node = target["node"].get<uint32_t>(), .property = *property};
  track.interpolation = readInterpolation(source, name);
  if (track.property == AnimatedProperty::Rotation) track.width = 4;
  if (track.property == AnimatedProperty::Weights) track.width = weightCount(document, track.node);
  if (track.width == 0) badInput("{} moves weights of nodes[{}], whose mesh has no morph targets", name, track.node);
  if (document.model.nodes[track.node].matrix.size() == 16 && track.property != AnimatedProperty::Weights) {
    warn("{} moves nodes[{}], whose transform is a matrix: it stays as it is", name, track.node);
    return std::nullopt;
  }
  track.times = readTimes(document, source["input"].get<int>(), name);
  track.values = readValues(document, source["output"].get<int>(), track, name);
  return track;
}

Animation readAnimation(const Document& document, const json& source, size_t index) {
  Animation animation{.name = source.value("name", fmt::format("animation{}", index))};
  const json& channels = source["channels"];
  for (size_t i = 0; i < channels.size(); ++i) {
    std::optional<Track> track =
        readTrack(document, source, channels[i], fmt::format("animations[{}].channels[{}]", index, i));
    if (!track) continue;
    animation.duration = std::max(animation.duration, track->times.back());
    animation.tracks.push_back(std::move(*track));
  }
  return animation;
}

RigNode readRigNode(const tinygltf::Model& model, const tinygltf::Node& source) {
  RigNode node;
  const auto at = [](const std::vector<double>& v, size_t i, double otherwise) {
    return i < v.size() ? v[i] : otherwise;
  };
  node.hasMatrix = source.matrix.size() == 16;
  if (node.hasMatrix) node.matrix = readMatrix(source.matrix);
  for (int i = 0; i < 3; ++i) node.translation[i] = at(source.translation, size_t(i), 0);
  for (int i = 0; i < 3; ++i) node.scale[i] = at(source.scale, size_t(i), 1);
  for (int i = 0; i < 4; ++i) node.rotation[i] = at(source.rotation, size_t(i), i == 3 ? 1 : 0);
  if (source.mesh < 0) return node;
  const tinygltf::Mesh& mesh = model.meshes[size_t(source.mesh)];
  const std::vector<double>& weights = source.weights.empty() ? mesh.weights : source.weights;
  for (size_t i = 0; i < mesh.primitives[0].targets.size(); ++i) node.weights.push_back(float(at(weights, i, 0)));
  return node;
}

std::vector<RigNode> readRigNodes(const tinygltf::Model& model) {
  std::vector<RigNode> nodes;
  for (const tinygltf::Node& source : model.nodes) nodes.push_back(readRigNode(model, source));
  for (size_t i = 0; i < model.nodes.size(); ++i)
    for (int child : model.nodes[i].children) nodes[size_t(child)].parent = int(i);
  return nodes;
}

std::vector<uint32_t> parentsFirst(const tinygltf::Model& model, const std::vector<RigNode>& nodes) {
  std::vector<uint32_t> order;
  for (size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].parent < 0) order.push_back(uint32_t(i));
  for (size_t next = 0; next < order.size(); ++next)
    for (int child : model.nodes[order[next]].children) order.push_back(uint32_t(child));
  return order;
}

}  // namespace

Skin readSkin(const Document& document, int index) {
  const tinygltf::Skin& source = document.model.skins[size_t(index)];
  if (source.joints.empty()) badInput("skins[{}] has no joints", index);
  Skin skin{.joints = {source.joints.begin(), source.joints.end()},
            .inverseBind = std::vector<mat4>(source.joints.size(), mat4(1))};
  if (source.inverseBindMatrices < 0) return skin;
  const Elements elements = resolve(document, source.inverseBindMatrices);
  if (elements.count < source.joints.size())
    badInput("skins[{}] has {} joints but {} inverse bind matrices", index, source.joints.size(), elements.count);
  document.budget.charge(elements.count * sizeof(mat4), elements.name);
  skin.inverseBind = readMatrices(elements);
  skin.inverseBind.resize(source.joints.size());
  for (mat4& m : skin.inverseBind) m = glm::row(m, 3, vec4(0, 0, 0, 1));  // as glTF 2.0, 3.7.3.1 requires
  return skin;
}

void readRig(const Document& document, const Hierarchy& hierarchy, Scene& scene) {
  std::vector<Animation> animations;
  for (size_t i = 0; i < document.animations.size(); ++i)
    animations.push_back(readAnimation(document, document.animations[i], i));
  if (animations.empty()) return;
  Rig& rig = scene.rig;
  rig.animations = std::move(animations);
  document.budget.charge(document.model.nodes.size() * sizeof(RigNode), "the node tree");
  rig.nodes = readRigNodes(document.model);
  rig.order = parentsFirst(document.model, rig.nodes);
  for (size_t i = 0; i < document.model.skins.size(); ++i) rig.skins.push_back(readSkin(document, int(i)));
  rig.sceneNodes.assign(hierarchy.order.begin(), hierarchy.order.end());
}

}  // namespace latelight::scene::gltf
