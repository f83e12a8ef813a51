// Curvature of triangle meshes at their vertices, by the discrete operators of Meyer, Desbrun, Schroeder and Barr 2002,
// "Discrete Differential-Geometry Operators for Triangulated 2-Manifolds", sections 3.3 to 3.5: the mean curvature from
// the cotangent formula, and the Gaussian curvature from the angle defect, both over mixed Voronoi areas.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// Returns the mean curvature (1/m, positive where the surface bends away from its normals, as that of a sphere) and the
// Gaussian curvature (1/m^2) at each vertex of the mesh at rest. `linear`: from the mesh's object space to a frame in
// meters.
//
// Vertices at the same position count as one, because seams of normals and texture coordinates split vertices. The
// operators require a neighborhood that is a disk. All other vertices, at boundaries and at edges with more than two
// triangles, have the mean of their neighbors that have one, or 0.
std::vector<glm::vec2> vertexCurvatures(const Mesh& mesh, const glm::dmat3& linear);

}  // namespace latelight::scene
