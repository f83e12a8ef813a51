// Keypoints of a data set's objects: named points that every object with such nodes has.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "labels/keypoints.h"
#include "output/id_manifest.h"

namespace latelight::data {

struct ObjectKeypoint {
  std::string name;
  std::string node;        // path below the object's node; empty: the object's node itself
  glm::dvec3 position{0};  // in the node's frame
  double thickness = 0;    // labels::Keypoint::thickness
  bool operator==(const ObjectKeypoint&) const = default;
};

// Reads a job's list of keypoints. Throws Error(Usage) that begins with `path`.
std::vector<ObjectKeypoint> readKeypoints(const nlohmann::ordered_json& list, const std::string& path);

// The keypoints of objects by id, in the order of the list. Objects that have none of the nodes are absent; a keypoint
// whose node an object lacks is outside of the image, and its coordinates are NaN.
using KeypointsOfObjects = std::map<uint32_t, std::vector<labels::ProjectedKeypoint>>;
KeypointsOfObjects keypointsOfObjects(render::Renderer& renderer, const scene::Scene& scene,
                                      const scene::Camera& camera, const render::Settings& settings,
                                      const render::SceneState& moment, const output::IdManifest& ids,
                                      const std::vector<ObjectKeypoint>& keypoints);

}  // namespace latelight::data
