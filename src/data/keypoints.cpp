#include "data/keypoints.h"

#include <fmt/format.h>

#include <limits>
#include <set>

#include "base/error.h"
#include "data/spec.h"

namespace latelight::data {

std::vector<ObjectKeypoint> readKeypoints(const nlohmann::ordered_json& list, const std::string& path) {
  if (!list.is_array() || list.empty()) badUsage("{} must be a list of at least one keypoint", path);
  std::vector<ObjectKeypoint> keypoints;
  std::set<std::string> names;
  for (size_t i = 0; i < list.size(); ++i) {
    Spec spec(list[i], fmt::format("{}[{}]", path, i));
    ObjectKeypoint keypoint{.name = spec.text("name"), .node = spec.text("node", "")};
    if (spec.has("position")) keypoint.position = spec.vector("position");
    keypoint.thickness = spec.number("thickness", kNotNegative, 0.0);
    spec.finish();
    if (!names.insert(keypoint.name).second) badUsage("{} has two keypoints named \"{}\"", path, keypoint.name);
    keypoints.push_back(std::move(keypoint));
  }
  return keypoints;
}

KeypointNodes::KeypointNodes(const scene::Scene& scene, const std::vector<ObjectKeypoint>& keypoints)
    : keypoints_(keypoints) {
  for (const scene::Node& node : scene.nodes) paths_.insert(node.path);
  for (const auto& [node, copy] : scene.nodeCopies)
    if (copy.node >= 0) originals_[scene.nodes[node].path] = scene.nodes[static_cast<size_t>(copy.node)].path;
  for (const ObjectKeypoint& keypoint : keypoints) {
    const int node = keypoint.node.starts_with('/') ? labels::findNode(scene, keypoint.node) : -1;
    ids_.push_back(node < 0 ? std::set<uint32_t>() : labels::objectsOfNode(scene, static_cast<uint32_t>(node)));
  }
}

std::optional<std::string> KeypointNodes::of(const output::IdEntry& object, size_t i) const {
  if (object.parts.empty()) return std::nullopt;
  const std::string& node = keypoints_[i].node;
  if (node.starts_with('/')) {
    const bool isBelow = paths_.contains(node) && node.starts_with(object.node + "/");
    const bool isCopied = object.copy && node == object.node;  // each copy has an id of its own
    return isBelow || isCopied || ids_[i].contains(object.id) ? std::optional(node) : std::nullopt;
  }
  const auto original = originals_.find(object.node);
  const std::string& own = original == originals_.end() ? object.node : original->second;
  const std::string path = node.empty() ? own : own + "/" + node;
  return paths_.contains(path) ? std::optional(path) : std::nullopt;
}

KeypointsOfObjects keypointsOfObjects(render::Renderer& renderer, const scene::Scene& scene,
                                      const scene::Camera& camera, const render::Settings& settings,
                                      const render::SceneState& moment, const output::IdManifest& ids,
                                      const std::vector<ObjectKeypoint>& keypoints) {
  const KeypointNodes nodes(scene, keypoints);
  std::vector<labels::Keypoint> points;
  std::vector<std::pair<uint32_t, size_t>> owners;  // the object and the number of each point
  for (const output::IdEntry& entry : ids.ids)
    for (size_t i = 0; i < keypoints.size(); ++i) {
      std::optional<std::string> node = nodes.of(entry, i);
      if (!node) continue;
      points.push_back({keypoints[i].name, std::move(*node), keypoints[i].position, keypoints[i].thickness, entry.id});
      owners.emplace_back(entry.id, i);
    }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const labels::ProjectedKeypoint missing{.position = glm::dvec3(kNone), .pixel = glm::dvec2(kNone), .depth = kNone};
  KeypointsOfObjects result;
  if (points.empty()) return result;
  const std::vector<labels::ProjectedKeypoint> projected =
      labels::projectKeypoints(renderer, scene, camera, settings, moment, points);
  for (size_t i = 0; i < owners.size(); ++i) {
    std::vector<labels::ProjectedKeypoint>& own = result[owners[i].first];
    own.resize(keypoints.size(), missing);
    own[owners[i].second] = projected[i];
  }
  return result;
}

}  // namespace latelight::data
