#include "data/variations/surface.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "data/cameras/target.h"
#include "scene/exact_math.h"

namespace latelight::data {

using glm::dvec3;

Surface::Surface(const scene::Scene& scene, const std::string& node, double slope, const std::string& path) {
  const double steepest = exact::cosQuarters(slope / 90);
  double area = 0;
  for (const uint32_t number : instancesBelow(scene, node, path)) {
    const scene::Instance& instance = scene.instances[number];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const glm::dmat4& toWorld = instance.toWorld;
    const double front = glm::determinant(glm::dmat3(toWorld)) < 0 ? -1 : 1;  // mirroring flips the winding order
    const auto at = [&](size_t i) { return dvec3(toWorld * glm::dvec4(mesh.positions[mesh.indices[i]], 1)); };
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const dvec3 corner = at(i), a = at(i + 1) - corner, b = at(i + 2) - corner, normal = glm::cross(a, b) * front;
      const double twice = glm::length(normal);
      if (!(twice > 0) || normal.z < steepest * twice) continue;  // up is Z
      triangles_.push_back({corner, a, b, area += twice / 2});
    }
  }
  if (triangles_.empty()) badUsage("{}: nothing of \"{}\" faces up within {} degrees", path, node, slope);
}

dvec3 Surface::point(Random& random) const {
  const double area = random.unit() * triangles_.back().areaUpTo;
  const auto found = std::ranges::upper_bound(triangles_, area, {}, &Triangle::areaUpTo);
  const Triangle& t = found == triangles_.end() ? triangles_.back() : *found;
  const double root = std::sqrt(random.unit()), share = random.unit();
  return t.corner + t.a * (root * (1 - share)) + t.b * (root * share);
}

}  // namespace latelight::data
