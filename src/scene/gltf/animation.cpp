// Animations and skins (glTF 2.0, 3.7.3 and 3.11), and the nodes in the form that animation requires.
#include <algorithm>
#include <array>
#include <glm/gtc/matrix_access.hpp>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/accessor_types.h"
#include "scene/gltf/mesh.h"
#include "scene/gltf/nodes.h"
#include "scene/gltf/pointer.h"
#include "scene/gltf/skin.h"
#include "scene/origin.h"

namespace latelight::scene::gltf {
namespace {

// The reason why a channel cannot be applied to the file. The channel is ignored, and the rest of the file is read.
struct Inapplicable {
  std::string reason;
};
template <typename... Args>
[[noreturn]] void skipTrack(fmt::format_string<Args...> format, Args&&... args) {
  throw Inapplicable{fmt::format(format, std::forward<Args>(args)...)};
}

Interpolation readInterpolation(const std::string& text) {
  if (text == "STEP") return Interpolation::Step;
  if (text == "LINEAR") return Interpolation::Linear;
  if (text == "CUBICSPLINE") return Interpolation::Cubic;
  skipTrack("has the unknown interpolation \"{}\"", text);
}

constexpr std::array<std::string_view, 4> kPaths{"translation", "rotation", "scale", "weights"};  // AnimatedProperty

AnimatedProperty readPath(const std::string& path) {
  const auto found = std::ranges::find(kPaths, path);
  if (found == kPaths.end()) skipTrack("moves \"{}\", which no node has", path);
  return AnimatedProperty(found - kPaths.begin());
}

uint32_t weightCount(const Document& document, uint32_t node) {
  const int mesh = document.model.nodes[node].mesh;
  return mesh < 0 ? 0 : static_cast<uint32_t>(targetCount(document.model.meshes[size_t(mesh)]));
}

template <int N>
std::vector<glm::vec<N, float>> readFiniteValues(const Elements& elements) {
  bool anyBroken = false;
  std::vector<glm::vec<N, float>> values = readRepaired<N>(elements, 0, elements.count, anyBroken);
  if (anyBroken) skipTrack("has values that are not finite numbers, in {}", elements.name);
  return values;
}

std::vector<float> readTimes(const Document& document, int accessor, const std::string& name) {
  const Elements elements = resolve(document, accessor);
  if (elements.components != 1 || elements.componentType != file::kFloat)
    badInput("{} has times that are not floats, in {}", name, elements.name);
  document.budget.charge(elements.count * sizeof(float), elements.name);
  std::vector<float> times;
  for (const glm::vec1& time : readFiniteValues<1>(elements)) times.push_back(time.x);
  if (!std::is_sorted(times.begin(), times.end())) skipTrack("has times that fall, in {}", elements.name);
  if (times.front() < 0) skipTrack("has a time before 0, in {}", elements.name);
  return times;
}

// The layout of a track's values in an accessor.
struct Layout {
  size_t components;               // components per element
  size_t elements;                 // elements per value
  bool normalized;                 // integers are normalized even if the accessor does not state so
  bool boolean = false;            // unsigned bytes
  std::string_view property = {};  // "translation"; empty if any vectors are permitted
};

std::vector<float> readValues(const Document& document, int accessor, const Curve& curve, const Layout& layout,
                              const std::string& name) {
  Elements elements = resolve(document, accessor);
  elements.normalized |= layout.normalized;
  const size_t keys = curve.interpolation == Interpolation::Cubic ? 3 : 1;
  if (elements.components != layout.components || elements.count != curve.times.size() * keys * layout.elements)
    badInput("{} has {} times, for which {} has the wrong number of values or components", name, curve.times.size(),
             elements.name);
  checkType(elements, AccessorUse::Animation, layout.property, fmt::format("{}'s {}", name, layout.property));
  const bool bytes = elements.componentType == file::kUnsignedByte;
  if (layout.boolean && (!bytes || curve.interpolation != Interpolation::Step))
    skipTrack("says what is visible in {} by other than steps of unsigned bytes", elements.name);
  document.budget.charge(elements.count * sizeof(glm::vec4) * 2, elements.name);
  std::vector<float> values;
  values.reserve(elements.count * elements.components);
  const auto append = [&](const auto& vectors) {
    for (const auto& v : vectors)
      for (int c = 0; c < v.length(); ++c) values.push_back(v[c]);
  };
  if (elements.components == 1) append(readFiniteValues<1>(elements));
  if (elements.components == 2) append(readFiniteValues<2>(elements));
  if (elements.components == 3) append(readFiniteValues<3>(elements));
  if (elements.components == 4) append(readFiniteValues<4>(elements));
  return values;
}

class AnimationReader {
 public:
  AnimationReader(const Document& document, const Hierarchy& hierarchy, const Scene& scene)
      : document_(document), hierarchy_(hierarchy), scene_(scene) {}

  Animation read(const file::Animation& source, size_t index) {
    out_ = {.name = source.name.value_or(fmt::format("animation{}", index))};
    source_ = &source;
    for (size_t i = 0; i < source.channels.size(); ++i) {
      name_ = fmt::format("animations[{}].channels[{}]", index, i);
      try {
        readChannel(source.channels[i]);
      } catch (const Inapplicable& channel) {
        warn("{} {}, and is left out", name_, channel.reason);
      }
    }
    return std::move(out_);
  }

 private:
  void readChannel(const file::AnimationChannel& channel) {
    const std::vector<file::AnimationSampler>& samplers = source_->samplers;
    if (channel.sampler >= samplers.size())
      badInput("{}.sampler is {}, but there are {} samplers", name_, channel.sampler, samplers.size());
    sampler_ = &samplers[channel.sampler];
    if (channel.path == "pointer") return readPointer(channel);
    const AnimatedProperty property = readPath(channel.path);
    if (channel.node >= 0) addTrack(uint32_t(channel.node), property, -1);
  }

  void readPointer(const file::AnimationChannel& channel) {
    if (!channel.pointer) badInput("{} targets a pointer, but has none", name_);
    const auto found = resolvePointer(document_, hierarchy_, scene_, *channel.pointer, name_, unsupported_);
    if (!found) return;
    if (const auto* pointed = std::get_if<NodeProperty>(&*found))
      for (const uint32_t node : pointed->nodes) addTrack(node, pointed->property, pointed->element);
    else
      addValues(std::get<ElementProperty>(*found));
  }

  void addTrack(uint32_t node, AnimatedProperty property, int element) {
    Track track;
    track.node = node;
    track.property = property;
    track.element = element;
    const bool weights = property == AnimatedProperty::Weights, visible = property == AnimatedProperty::Visible;
    if (property == AnimatedProperty::Rotation) track.width = 4;
    if (weights) track.width = element < 0 ? weightCount(document_, node) : 1;
    if (visible) track.width = 1;
    if (weights && weightCount(document_, node) == 0)
      skipTrack("moves weights of nodes[{}], whose mesh has no morph targets", node);
    if (!document_.model.nodes[node].matrix.empty() && !weights && !visible)
      return warn("{} moves nodes[{}], whose transform is a matrix: it stays as it is", name_, node);
    const Layout layout{.components = weights ? 1 : track.width,
                        .elements = weights ? track.width : 1,
                        .normalized = !visible,  // rotations and weights allow no other integers
                        .boolean = visible,
                        .property = visible ? "" : kPaths[size_t(property)]};
    readCurve(track, layout);
    out_.tracks.push_back(std::move(track));
  }

  void addValues(const ElementProperty& property) {
    ValueTrack track;
    track.elements = property.elements;
    track.indices = property.indices;
    track.property = property.value.property;
    track.slot = property.value.slot;
    track.width = property.value.width;
    readCurve(track, {.components = track.width, .elements = 1, .normalized = false});
    out_.values.push_back(std::move(track));
  }

  void readCurve(Curve& curve, const Layout& layout) {
    curve.interpolation = readInterpolation(sampler_->interpolation);
    curve.times = readTimes(document_, sampler_->input, name_);
    curve.values = readValues(document_, sampler_->output, curve, layout, name_);
    out_.duration = std::max(out_.duration, curve.times.back());
  }

  const Document& document_;
  const Hierarchy& hierarchy_;
  const Scene& scene_;
  const file::Animation* source_ = nullptr;
  const file::AnimationSampler* sampler_ = nullptr;  // the channel's
  std::string name_;                                 // the channel's name in messages
  std::set<std::string> unsupported_;                // properties of which a warning was printed
  Animation out_;
};

// Returns the node except for its parent and its matrix.
RigNode readRigNode(const file::Model& model, const file::Node& source) {
  RigNode node;
  node.visible = source.visible;
  node.hasMatrix = !source.matrix.empty();
  node.translation = source.translation;
  node.rotation = source.rotation;
  node.scale = source.scale;
  if (source.mesh < 0) return node;
  const file::Mesh& mesh = model.meshes[size_t(source.mesh)];
  const std::vector<double>& weights = source.weights.empty() ? mesh.weights : source.weights;
  for (size_t i = 0; i < targetCount(mesh); ++i) node.weights.push_back(i < weights.size() ? float(weights[i]) : 0);
  return node;
}

std::vector<RigNode> readRigNodes(const file::Model& model) {
  std::vector<RigNode> nodes;
  for (const file::Node& source : model.nodes) {
    nodes.push_back(readRigNode(model, source));
    if (nodes.back().hasMatrix) nodes.back().matrix = readMatrix(source.matrix);
  }
  for (size_t i = 0; i < model.nodes.size(); ++i)
    for (int child : model.nodes[i].children) nodes[size_t(child)].parent = int(i);
  return nodes;
}

std::vector<RigNode> readFileNodes(const file::Model& model, const Hierarchy& hierarchy, const Scene& scene) {
  std::vector<RigNode> nodes;
  nodes.reserve(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    nodes.push_back(readRigNode(model, model.nodes[size_t(hierarchy.order[i])]));
    if (nodes.back().hasMatrix) nodes.back().matrix = scene.nodes[i].local;
  }
  return nodes;
}

std::vector<uint32_t> parentsFirst(const file::Model& model, const std::vector<RigNode>& nodes) {
  std::vector<uint32_t> order;
  for (size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].parent < 0) order.push_back(uint32_t(i));
  for (size_t next = 0; next < order.size(); ++next)
    for (int child : model.nodes[order[next]].children) order.push_back(uint32_t(child));
  return order;
}

}  // namespace

glm::dvec3 skinOrigin(const Document& document, const Hierarchy& hierarchy, int index) {
  const std::vector<int>& joints = document.model.skins[size_t(index)].joints;
  glm::dvec3 mean(0);
  for (const int joint : joints) mean += glm::dvec3(hierarchy.world[size_t(joint)][3]) / double(joints.size());
  return originNear(mean);
}

Skin readSkin(const Document& document, const Hierarchy& hierarchy, int index) {
  const file::Skin& source = document.model.skins[size_t(index)];
  if (source.joints.empty()) badInput("skins[{}] has no joints", index);
  Skin skin{.joints = {source.joints.begin(), source.joints.end()},
            .inverseBind = std::vector<mat4>(source.joints.size(), mat4(1)),
            .origin = skinOrigin(document, hierarchy, index)};
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
  AnimationReader reader(document, hierarchy, scene);
  for (const file::Animation& source : document.model.animations)
    animations.push_back(reader.read(source, animations.size()));
  document.budget.charge(document.model.nodes.size() * sizeof(RigNode), "the node tree");
  if (animations.empty() && document.model.skins.empty()) {
    scene.fileNodes = readFileNodes(document.model, hierarchy, scene);
    return;
  }
  Rig& rig = scene.rig;
  rig.animations = std::move(animations);
  rig.nodes = readRigNodes(document.model);
  rig.order = parentsFirst(document.model, rig.nodes);
  for (size_t i = 0; i < document.model.skins.size(); ++i) rig.skins.push_back(readSkin(document, hierarchy, int(i)));
  for (const Animation& animation : rig.animations)
    for (const ValueTrack& track : animation.values)
      if (track.elements == AnimatedElements::Materials)
        for (const uint32_t material : track.indices) rig.materials[material];  // readMaterials() fills them
  rig.sceneNodes.assign(hierarchy.order.begin(), hierarchy.order.end());
}

}  // namespace latelight::scene::gltf
