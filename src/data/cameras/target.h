// The target that cameras look at, and the distance at which it fits in the picture.
#pragma once

#include <optional>
#include <string>

#include "data/cameras/bvh.h"
#include "data/cameras/source.h"

namespace latelight::data {

// Return for each node of the scene if it is any node with this name or path or below it, and the indices of the shown
// instances of these nodes. Throw Error(Usage) whose message begins with `path` if there is no such node.
std::vector<bool> nodesBelow(const scene::Scene& scene, const std::string& node, const std::string& path);
std::vector<uint32_t> instancesBelow(const scene::Scene& scene, const std::string& node, const std::string& path);

// Return the bounding box of instances, or of all shown instances, in the scene file's own frame. Throw Error(Usage)
// whose message begins with `path` if there is no geometry.
Aabb boxOf(const scene::Scene& scene, const std::vector<uint32_t>& instances, const std::string& path);
Aabb boxOfScene(const scene::Scene& scene, const std::string& path);

struct Target {
  glm::dvec3 center{0};
  double radius = 0;  // radius of the geometry; 0: a point
};

// Reads "target": "scene", [x, y, z] or {"node": "name or path"}. The default is the scene.
Target readTarget(Spec& spec, const CameraContext& context);

// Reads the distance from `key`, such as "distance". The default is the distance at which the target fits in the
// picture.
Interval readDistance(Spec& spec, std::string_view key, const Target& target, double halfAngle);

}  // namespace latelight::data
