#include "data/keypoints.h"

#include <fmt/format.h>

#include <limits>
#include <set>
#include <unordered_set>

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

KeypointsOfObjects keypointsOfObjects(render::Renderer& renderer, const scene::Scene& scene,
                                      const scene::Camera& camera, const render::Settings& settings,
                                      const render::SceneState& moment, const output::IdManifest& ids,
                                      const std::vector<ObjectKeypoint>& keypoints) {
  std::unordered_set<std::string> paths;
  for (const scene::Node& node : scene.nodes) paths.insert(node.path);
  std::vector<labels::Keypoint> points;
  std::vector<std::pair<uint32_t, size_t>> owners;  // the object and the number of each point
  for (const output::IdEntry& entry : ids.ids) {
    if (entry.parts.empty()) continue;
    for (size_t i = 0; i < keypoints.size(); ++i) {
      const ObjectKeypoint& k = keypoints[i];
      const std::string node = k.node.empty() ? entry.node : entry.node + "/" + k.node;
      if (!paths.contains(node)) continue;
      points.push_back({k.name, node, k.position, k.thickness});
      owners.emplace_back(entry.id, i);
    }
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
