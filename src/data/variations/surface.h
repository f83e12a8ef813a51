// Points on a node's triangles, as many on each as its area says.
#pragma once

#include <vector>

#include "data/random.h"
#include "scene/scene.h"

namespace latelight::data {

class Surface {
 public:
  // Of triangles that face upwards, within `slope` degrees. Throws Error(Usage) that begins with `path` where there are
  // none.
  Surface(const scene::Scene& scene, const std::string& node, double slope, const std::string& path);
  glm::dvec3 point(Random& random) const;  // world

 private:
  struct Triangle {
    glm::dvec3 corner, a, b;  // edges from the corner
    double areaUpTo;          // of it and all before
  };
  std::vector<Triangle> triangles_;
};

}  // namespace latelight::data
