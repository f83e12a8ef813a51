// What cameras look at.
#pragma once

#include <optional>
#include <string>

#include "data/cameras/bvh.h"
#include "data/cameras/source.h"

namespace latelight::data {

// What lies at or below a node that has this name or path, or one of several of that name: instances' numbers. Throws
// Error(Usage) that begins with `path` where there is none.
std::vector<uint32_t> instancesBelow(const scene::Scene& scene, const std::string& node, const std::string& path);

// Of the instances' boxes, in the scene file's own frame; throws Error(Usage) that begins with `path` where nothing is
// there.
Aabb boxOf(const scene::Scene& scene, const std::vector<uint32_t>& instances, const std::string& path);
Aabb boxOfScene(const scene::Scene& scene, const std::string& path);

struct Target {
  glm::dvec3 centre{0};
  double radius = 0;  // of what is there; 0: a point
};

// "target": "scene", [x, y, z] or {"node": "name or path"}; the scene where it is missing.
Target readTarget(Spec& spec, const CameraContext& context);

// "distance" or another key that says how far away: the key's, or where it is missing, as far that the target fits.
Interval readDistance(Spec& spec, std::string_view key, const Target& target, double halfAngle);

}  // namespace latelight::data
