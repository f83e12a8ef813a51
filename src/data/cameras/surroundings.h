// What is around a point of a scene at rest: whether it lies inside something solid, and how far the nearest surface
// is. The scene's own triangles, each tested exactly.
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

  // Points are in the scene file's own frame. Inside: a node's triangles, all primitives of its mesh together, wind
  // around the point. Fronts face outwards, so that rooms seen from within are not solid. Of what has holes that is so
  // where more than half of the directions lead to its inner side.
  bool inside(glm::dvec3 point) const;
  // Metres to the nearest surface, or `limit` where none is nearer.
  double nearest(glm::dvec3 point, double limit = std::numeric_limits<double>::infinity()) const;

 private:
  struct Piece;  // an instance
  Piece pieceOf(uint32_t instance) const;

  std::vector<std::unique_ptr<Bvh>> meshes_;
  std::vector<Piece> pieces_;
  std::unique_ptr<Bvh> tree_;
  const scene::Scene& scene_;
  MemoryClaim memory_;
};

}  // namespace latelight::data
