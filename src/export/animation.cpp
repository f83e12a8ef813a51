// Writes skins and animations. Animated properties of materials, lights and cameras are channels of
// KHR_animation_pointer.

#include <fmt/format.h>

#include "export/nodes.h"
#include "scene/animated_pointers.h"

namespace latelight::exports {
namespace {

using namespace scene;

constexpr const char* kPointer = "KHR_animation_pointer";

class AnimationWriter {
 public:
  AnimationWriter(Document& document, const Exported& exported) : document_(document), exported_(exported) {}

  void add(const Animation& animation) {
    out_ = {{"name", animation.name}, {"channels", Json::array()}, {"samplers", Json::array()}};
    for (const Track& track : animation.tracks) addTrack(track);
    for (const ValueTrack& track : animation.values) addValues(track);
    if (out_["channels"].empty()) addNeutralChannel();
    document_.add("animations", std::move(out_));
  }

 private:
  void addTrack(const Track& track) {
    const int node = exported_.rigNodes[track.node];
    if (track.property == AnimatedProperty::Visible)
      return addPointer(fmt::format("/nodes/{}/extensions/KHR_node_visibility/visible", node), addVisibility(track));
    const bool areWeights = track.property == AnimatedProperty::Weights;
    std::vector<int> nodes;
    if (!areWeights || hasTargets(node)) nodes.push_back(node);
    const auto [copy, end] = (areWeights ? exported_.morphedCopies : exported_.movedCopies).equal_range(track.node);
    for (auto i = copy; i != end; ++i) nodes.push_back(i->second);
    if (nodes.empty()) return;
    const size_t sampler = addSampler(track, areWeights);
    for (const int i : nodes) addChannel(track, i, sampler);
  }

  // Adds a channel without a node, which readers ignore (glTF 2.0, 3.11), because an animation has at least one
  // channel. An animation without applicable channels is written, so that the others keep their indices.
  void addNeutralChannel() {
    const Curve zero{.times = {0}, .values = {0, 0, 0}};
    out_["channels"].push_back({{"sampler", addSampler(zero, false)}, {"target", {{"path", "translation"}}}});
  }

  // An edit may have replaced the node's mesh by one without morph targets, or without triangles.
  bool hasTargets(int node) const {
    const Json& source = document_.root["nodes"][static_cast<size_t>(node)];
    if (!source.contains("mesh")) return false;
    return document_.root["meshes"][source["mesh"].get<size_t>()]["primitives"][0].contains("targets");
  }

  void addChannel(const Track& track, int node, size_t sampler) {
    constexpr std::array kPaths = {"translation", "rotation", "scale", "weights"};
    if (track.element >= 0) return addPointer(fmt::format("/nodes/{}/weights/{}", node, track.element), sampler);
    const char* path = kPaths[static_cast<size_t>(track.property)];
    out_["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
  }

  // A track of several elements has a channel for each.
  void addValues(const ValueTrack& track) {
    std::optional<size_t> sampler;
    for (const uint32_t element : track.indices) {
      const auto [list, name] = listOf(track.elements);
      const int index = element < list->size() ? (*list)[element] : -1;
      if (index < 0) continue;
      if (!sampler) sampler = addSampler(track, false);
      addPointer(fmt::format("{}{}/{}", name, index, animatedPointer(track.elements, track.property, track.slot)),
                 *sampler);
    }
  }

  std::pair<const std::vector<int>*, const char*> listOf(AnimatedElements elements) const {
    if (elements == AnimatedElements::Lights) return {&exported_.lights, "/extensions/KHR_lights_punctual/lights/"};
    if (elements == AnimatedElements::Cameras) return {&exported_.cameras, "/cameras/"};
    return {&exported_.materials, "/materials/"};
  }

  void addPointer(const std::string& pointer, size_t sampler) {
    Json target{{"path", "pointer"}};
    document_.extension(target, kPointer)["pointer"] = pointer;
    out_["channels"].push_back({{"sampler", sampler}, {"target", std::move(target)}});
  }

  // Weights are scalars, all of a key one after another.
  size_t addSampler(const Curve& curve, bool areScalars) {
    constexpr std::array kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    return addSampler(
        curve, document_.addNumbers(curve.values, areScalars ? "SCALAR" : kTypes[curve.width - 1], Target::None));
  }

  size_t addVisibility(const Curve& curve) {
    return addSampler(curve, document_.addBytes(std::vector<uint8_t>(curve.values.begin(), curve.values.end())));
  }

  size_t addSampler(const Curve& curve, size_t output) {
    constexpr std::array kInterpolations = {"STEP", "LINEAR", "CUBICSPLINE"};
    const size_t input = document_.addFloats(curve.times);
    Json& accessor = document_.root["accessors"][input];
    accessor["min"] = {shortest(curve.times.front())};
    accessor["max"] = {shortest(curve.times.back())};
    out_["samplers"].push_back({{"input", input},
                                {"interpolation", kInterpolations[static_cast<size_t>(curve.interpolation)]},
                                {"output", output}});
    return out_["samplers"].size() - 1;
  }

  Document& document_;
  const Exported& exported_;
  Json out_;
};

}  // namespace

void addSkins(const Scene& scene, Document& document, const Exported& exported) {
  std::vector<size_t> matrices;
  for (const Skin& skin : scene.rig.skins) {
    Json joints = Json::array();
    for (const uint32_t joint : skin.joints) joints.push_back(exported.rigNodes[joint]);
    matrices.push_back(document.addMatrices(skin.inverseBind));
    document.add("skins", {{"inverseBindMatrices", matrices.back()}, {"joints", std::move(joints)}});
  }
  for (const SkinCopy& copy : exported.skinCopies)
    document.add("skins", {{"inverseBindMatrices", matrices[copy.skin]}, {"joints", copy.joints}});
}

void addAnimations(const Scene& scene, Document& document, const Exported& exported) {
  AnimationWriter writer(document, exported);
  for (const Animation& animation : scene.rig.animations) writer.add(animation);
}

}  // namespace latelight::exports
