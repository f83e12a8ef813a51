// Meshes of light volumes, circumscribed around the space that a point or spot light reaches: no lit point lies outside
// them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace latelight::render {

// One sphere and one cone. Indices are relative to the first vertex of each part; triangles are counter-clockwise seen
// from outside. Vertices are the data from which volume.vert computes positions:
//   sphere  the position for a light of radius 1 at the origin
//   cone    x, y: direction from the axis, of length 1 / cos(pi / sides) plus a margin; z: the ring (kCone*)
struct VolumeMesh {
  struct Part {
    uint32_t firstIndex, indexCount, firstVertex;
  };
  std::vector<glm::vec3> vertices;
  std::vector<uint32_t> indices;
  Part sphere, cone;
};
VolumeMesh makeVolumeMesh();

// Every point of both meshes lies within this distance of the light, in radii.
inline constexpr float kVolumeExtent = 1.4f;

// Scale that compensates for the rasterizer, which snaps vertices to 1/256 pixel. It suffices for volumes down to half
// a pixel across.
inline constexpr float kVolumeMargin = 1.01f;

// The rings of the cone, from the light outward (volume.vert): the tip; the rim, where the cone intersects the sphere
// of its radius; and the top, where the tangent at the rim intersects the sphere's tangent plane at the far end.
inline constexpr float kConeTip = 0, kConeRim = 1, kConeTop = 2;

}  // namespace latelight::render
