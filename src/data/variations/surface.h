// Samples points on a node's triangles, uniformly by area.
#pragma once

#include <vector>

#include "data/random.h"
#include "scene/scene.h"

namespace latelight::data {

class Surface {
 public:
  // Uses triangles that face up within `slope` degrees. Throws Error(Usage) whose message begins with `path` if there
  // are none.
  Surface(const scene::Scene& scene, const std::string& node, double slope, const std::string& path);
  glm::dvec3 point(Random& random) const;  // in the world

 private:
  struct Triangle {
    glm::dvec3 corner, a, b;  // edges from the corner
    double areaUpTo;          // cumulative area, including this triangle
  };
  std::vector<Triangle> triangles_;
};

}  // namespace latelight::data
