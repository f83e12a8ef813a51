// Normals and tangents of a mesh whose vertices move. The fan of a vertex is the set of triangles around its position
// whose corners there have the same normal at rest. Vertices that were split at a seam of the texture coordinates thus
// keep a common normal, and a crease stays a crease.
//
// The normal is the mean of the fan's normals, weighted by the areas of its triangles (Max 1999, "Weights for Computing
// Vertex Normals from Facet Normals", section 1). The tangent at rest is a sum of edges of these triangles, and the
// same sum of the moved edges, without its part along the normal, is the moved tangent.
// render/deform/deform_vertices.comp does the same on the device, in doubles and in the same order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// The tangent of a vertex at rest is the sum of along[0] * (b - a) + along[1] * (c - a) over its fan, up to its length
// and its part along the normal, for triangles with the corners a, b and c.
struct FanTriangle {
  uint32_t triangle;
  float along[2];
};

struct VertexFans {
  std::vector<uint32_t> first;  // per vertex, index of its fan's first triangle; then the number of all triangles
  std::vector<FanTriangle> triangles;
};

VertexFans vertexFans(const Mesh& mesh);

// Returns the attributes of the mesh if its vertices are at these positions, one per vertex. A vertex whose triangles
// all have the area 0 keeps its normal, and one without a tangent has none.
std::vector<shared::VertexAttributes> movedAttributes(const Mesh& mesh, const VertexFans& fans,
                                                      std::span<const glm::vec3> positions);

}  // namespace latelight::scene
