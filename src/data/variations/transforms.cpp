// The variation "transforms": random translation, rotation and scale of nodes. The instances and lights of moved nodes
// are moved here; cameras are moved by CameraTimeline::follow().
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/frames.h"
#include "data/variations/pattern.h"
#include "data/variations/variation.h"
#include "scene/file_frame.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
using glm::dmat4, glm::dvec3, glm::dvec4;

class Transforms : public Variation {
 public:
  Transforms(Spec& spec, const scene::Scene& scene) : path_(spec.path()) {
    nodes_ = selectNodes(spec, "nodes", scene);
    above_ = selectedAbove(scene, nodes_);
    findMoved(scene);
    findSkins(scene, spec.pathOf("nodes"));
    findLights(scene);
    if (spec.has("translation")) translation_ = spec.corners("translation");
    if (spec.has("rotation")) rotation_ = spec.interval("rotation");
    axis_ = spec.has("axis") ? spec.vector("axis") : upOf(scene);
    if (!(glm::length(axis_) > 0)) badUsage("{} must not be zero", spec.pathOf("axis"));
    axis_ /= glm::length(axis_);
    if (spec.has("scale")) scale_ = spec.interval("scale", kPositive);
    if (!translation_ && !rotation_ && !scale_)
      badUsage("{} needs one of \"translation\", \"rotation\" and \"scale\"", path_);
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    Json record{{"nodes", Json::array()}};
    std::map<uint32_t, dmat4> changes;  // transforms in the world, by node
    for (const uint32_t node : nodes_) changes[node] = change(draw, node, draft, record["nodes"].emplace_back());
    moveNodes(changes, draft);
    moveLights(draft);
    for (uint32_t i = 0; i < above_.size(); ++i) {
      if (above_[i].empty()) continue;
      dmat4 toWorld(draft.transform(i));
      for (const uint32_t node : above_[i]) toWorld = changes[node] * toWorld;
      draft.transform(i) = toWorld;
    }
    return record;
  }

 private:
  // Finds the nodes that are selected or below selected ones.
  void findMoved(const scene::Scene& scene) {
    const std::set<uint32_t> selected(nodes_.begin(), nodes_.end());
    for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
      std::vector<uint32_t> above;
      for (int at = static_cast<int>(i); at >= 0; at = scene.nodes[static_cast<size_t>(at)].parent)
        if (selected.contains(static_cast<uint32_t>(at))) above.push_back(static_cast<uint32_t>(at));
      if (!above.empty()) moved_.emplace_back(i, std::move(above));
    }
  }

  // Skinned meshes follow their joints (glTF 2.0, 3.7.3.3), so nodes above all of the joints move them as a whole. They
  // also move with their own nodes. `path`: of the job's key.
  void findSkins(const scene::Scene& scene, const std::string& path) {
    std::vector<const std::vector<uint32_t>*> ofRig(scene.rig.nodes.size());  // the lists of moved_, by node of the rig
    for (const auto& [node, above] : moved_)
      if (node < scene.rig.sceneNodes.size()) ofRig[scene.rig.sceneNodes[node]] = &above;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
      const scene::Instance& instance = scene.instances[i];
      if (instance.removed || !instance.posed) continue;
      const auto& deformation = scene.meshes[instance.mesh].deformation;
      if (!deformation || deformation->skin < 0) continue;
      std::map<uint32_t, size_t, std::greater<>> jointsBelow;  // their number, by selected node, children first
      const auto& joints = scene.rig.skins[static_cast<size_t>(deformation->skin)].joints;
      for (const uint32_t joint : joints)
        if (const std::vector<uint32_t>* above = ofRig[joint])
          for (const uint32_t node : *above) ++jointsBelow[node];
      const auto movesAll = [&](const auto& entry) { return entry.second == joints.size(); };
      const bool moves = !above_[i].empty() || std::ranges::any_of(jointsBelow, movesAll);
      for (const auto& [node, count] : jointsBelow) {
        if (std::ranges::find(above_[i], node) != above_[i].end()) continue;
        if (moves && count < joints.size()) continue;  // selected with others, such as by *
        if (count < joints.size())
          badUsage("{}: {} moves only some joints of {}, which cannot bend: select a node above all of its joints",
                   path, scene.nodes[node].path, scene.nodes[instance.node].path);
        above_[i].push_back(node);
      }
    }
  }

  // Finds the lights of the nodes that findMoved() has found.
  void findLights(const scene::Scene& scene) {
    std::vector<bool> isMoved(scene.nodes.size());
    for (const auto& [node, above] : moved_) isMoved[node] = true;
    for (uint32_t i = 0; i < scene.lights.size(); ++i) {
      const scene::Light& light = scene.lights[i];
      if (!light.removed && light.node >= 0 && isMoved[static_cast<size_t>(light.node)]) lights_.push_back(i);
    }
  }

  // `changes`: transforms in the world, by selected node.
  void moveNodes(std::map<uint32_t, dmat4>& changes, Draft& draft) const {
    for (const auto& [node, above] : moved_) {
      dmat4& toWorld = draft.nodeToWorld(node);
      for (const uint32_t each : above) toWorld = changes[each] * toWorld;
    }
  }

  // Lights that jitter has moved no longer follow a node.
  void moveLights(Draft& draft) const {
    for (const uint32_t i : lights_)
      if (scene::Light& light = draft.light(i); light.node >= 0)
        scene::placeLight(light, scene::toGltfFromWorld() * draft.nodeToWorld(static_cast<uint32_t>(light.node)));
  }

  // Returns a random transform in the world. It rotates and scales about the node's current origin, along the axes of
  // the file's frame.
  dmat4 change(const Draw& draw, uint32_t index, Draft& draft, Json& record) const {
    const scene::Scene& scene = draft.scene;
    const auto random = [&](const char* what) { return draw.of(fmt::format("{}/{}/{}", path_, index, what)); };
    record["node"] = scene.nodes[index].path;
    dmat4 moved(1);
    dvec3 translation(0);
    if (translation_) translation = drawn(*translation_, random("translation"));
    if (translation_) record["translation"] = {translation.x, translation.y, translation.z};
    if (rotation_) {
      const double degrees = drawn(*rotation_, random("rotation"));
      moved = turnAbout(axis_, degrees);
      record["rotation"] = degrees;
    }
    if (scale_) {
      const double scale = drawn(*scale_, random("scale"));
      for (int axis = 0; axis < 3; ++axis) moved[axis] *= scale;
      record["scale"] = scale;
    }
    const dvec3 origin(fileFromWorld(scene) * draft.nodeToWorld(index)[3]);
    moved[3] = dvec4(origin + translation - dvec3(moved * dvec4(origin, 0)), 1);
    return worldFromFile(scene) * moved * fileFromWorld(scene);
  }

  std::string path_;
  std::vector<uint32_t> nodes_;
  std::vector<std::vector<uint32_t>> above_;                       // by instance
  std::vector<std::pair<uint32_t, std::vector<uint32_t>>> moved_;  // nodes, each with those of nodes_ that move it
  std::vector<uint32_t> lights_;                                   // of the nodes in moved_
  std::optional<Spec::Corners> translation_;
  std::optional<Interval> rotation_, scale_;
  dvec3 axis_{0};
};

}  // namespace

std::unique_ptr<Variation> varyTransforms(Spec& spec, const VariationContext& context) {
  return std::make_unique<Transforms>(spec, context.scene);
}

}  // namespace latelight::data
