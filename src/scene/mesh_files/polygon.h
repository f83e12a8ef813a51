// Triangulates polygons.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene::mesh_files {

// Appends the triangles of a polygon as indices of its corners: always two fewer than it has corners. A convex polygon
// becomes a fan. Ears are cut from any other one (Meisters, "Polygons have ears", 1975), in the plane of its normal.
// The triangles of a polygon that intersects or touches itself may overlap.
void triangulate(std::span<const vec3> corners, std::vector<std::array<uint32_t, 3>>& triangles);

// Returns the normal of a polygon, whose length is twice its area (Sutherland et al., "A characterization of ten
// hidden-surface algorithms", 1974, which attributes it to Newell).
glm::dvec3 polygonNormal(std::span<const vec3> corners);

}  // namespace latelight::scene::mesh_files
