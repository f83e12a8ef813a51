// Point queries in a scene at rest: tests by winding numbers if a point is inside closed geometry, and finds the
// distance to the nearest surface. Both use the scene's triangles in double precision, found through BVHs.
#pragma once

#include <memory>
#include <vector>

#include "base/memory.h"
#include "data/cameras/bvh.h"
#include "scene/scene.h"

namespace latelight::data {

class Surroundings {
 public:
  explicit Surroundings(const scene::Scene& scene);
  ~Surroundings();

  // Points are in the scene file's own frame. A point is inside a node if the triangles of all primitives of the node's
  // mesh together wind around it. Front faces point outward, so the interior of a room is not inside. A mesh with holes
  // counts as closed at points from which more than half of the directions lead to its inner side.
  bool inside(glm::dvec3 point) const;
  // Returns the distance to the nearest surface in meters, or `limit` if no surface is nearer.
  double nearest(glm::dvec3 point, double limit = std::numeric_limits<double>::infinity()) const;

 private:
  struct Piece;  // one instance
  Piece pieceOf(uint32_t instance) const;

  std::vector<std::unique_ptr<Bvh>> meshes_;
  std::vector<Piece> pieces_;
  std::unique_ptr<Bvh> tree_;
  const scene::Scene& scene_;
  MemoryClaim memory_;
};

}  // namespace latelight::data
