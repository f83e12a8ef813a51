// Keypoints of a data set's objects: named points that every object with such nodes has.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "labels/keypoints.h"
#include "output/id_manifest.h"

namespace latelight::data {

struct ObjectKeypoint {
  std::string name;
  // Path below the object's node; empty: the object's node itself. One that begins with "/" is a path in the scene, and
  // only the objects that the node belongs to have the keypoint.
  std::string node;
  glm::dvec3 position{0};  // in the node's frame
  double thickness = 0;    // labels::Keypoint::thickness
  bool operator==(const ObjectKeypoint&) const = default;
};

// Reads a job's list of keypoints. Throws Error(Usage) that begins with `path`.
std::vector<ObjectKeypoint> readKeypoints(const nlohmann::ordered_json& list, const std::string& path);

// Completes messages: "node" is ...
constexpr std::string_view kKeypointNodeHelp =
    "a path below the object's own, as in \"Hips/Head\", or the path of a joint in the scene, as in "
    "\"/Armature/Hips/Head\"";

// The nodes that the keypoints follow on each object. The keypoints outlive it.
class KeypointNodes {
 public:
  KeypointNodes(const scene::Scene& scene, const std::vector<ObjectKeypoint>& keypoints);
  // Returns the path of the node of keypoint i on an object, or nothing if the object lacks it. On a copy of a part of
  // the scene it is the node of the original.
  std::optional<std::string> of(const output::IdEntry& object, size_t i) const;

 private:
  const std::vector<ObjectKeypoint>& keypoints_;
  std::unordered_set<std::string> paths_;
  std::unordered_map<std::string, std::string> originals_;  // paths of copied nodes by those of their copies
  std::vector<std::set<uint32_t>> ids_;  // per keypoint, the objects that a path in the scene belongs to
};

// The keypoints of objects by id, in the order of the list. Objects that have none of the nodes are absent; a keypoint
// whose node an object lacks is outside of the image, and its coordinates are NaN.
using KeypointsOfObjects = std::map<uint32_t, std::vector<labels::ProjectedKeypoint>>;
KeypointsOfObjects keypointsOfObjects(render::Renderer& renderer, const scene::Scene& scene,
                                      const scene::Camera& camera, const render::Settings& settings,
                                      const render::SceneState& moment, const output::IdManifest& ids,
                                      const std::vector<ObjectKeypoint>& keypoints);

}  // namespace latelight::data
