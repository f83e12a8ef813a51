// Circumscribed meshes around the volume that a point or a spot light reaches: no lit pixel lies outside them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace latelight::render {

// One sphere and one cone; indices are relative to each one's first vertex, triangles counter-clockwise from outside.
// Vertices are not positions but the data from which volume.vert computes them:
//   sphere  a position, for reach 1 about the origin
//   cone    x, y: direction from the axis, its length 1 / cos(half a side) and a margin; z: which ring (kCone*)
struct VolumeMesh {
  struct Part {
    uint32_t firstIndex, indexCount, firstVertex;
  };
  std::vector<glm::vec3> vertices;
  std::vector<uint32_t> indices;
  Part sphere, cone;
};
VolumeMesh makeVolumeMesh();

// Every point of both meshes lies within this many radii of the light.
inline constexpr float kVolumeExtent = 1.4f;

// Margin for the rasterizer, which snaps vertices to 1/256 pixel: enough for volumes down to half a pixel across.
inline constexpr float kVolumeMargin = 1.01f;

// The rings of the cone, from the light outwards (volume.vert): its tip, where the cone meets the sphere of its radius,
// and where the tangent there meets the tangent plane at the far end.
inline constexpr float kConeTip = 0, kConeRim = 1, kConeTop = 2;

}  // namespace latelight::render
