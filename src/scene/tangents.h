// Generates tangent frames for meshes that have a normal map but no tangents.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

namespace latelight::scene {

struct LoadOptions;
struct Material;

// The texture coordinates that tangents follow: a UV set, and the linear part of its texture's transform.
struct TangentSpace {
  uint32_t uvSet = 0;
  glm::vec2 row0{1, 0}, row1{0, 1};
  bool operator==(const TangentSpace&) const = default;
};

// Returns the space of the texture for which a material requires tangents, or nothing if it requires none.
std::optional<TangentSpace> tangentSpaceOf(const Material& material);
// Returns the space in which a loaded mesh with this material requires tangents, or nothing.
std::optional<TangentSpace> tangentSpaceOf(const Material& material, const LoadOptions& options);

struct TangentFrames {
  std::vector<glm::vec4> tangents;  // one per vertex, including appended ones: xyz unit, w the bitangent's sign
  // Vertices to append to the mesh, as copies of these, for vertices shared by triangles of both handednesses (mirrored
  // UVs).
  std::vector<uint32_t> copies;
};

// Generates tangents similar to MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, chapter 4),
// which glTF 2.0 (3.7.2.1) requires. Each triangle's UV gradient is projected to the vertex normal's plane and weighted
// by the corner's angle. Vertices equal in position, normal and UV share their tangent, even if they are separate
// vertices; triangles of different handedness do not. Unlike in MikkTSpace, triangles around a vertex need not be
// connected by edges to be averaged. Indices (3 per triangle) are changed to appended vertices if required. `uv` has v
// down, as in glTF.
TangentFrames generateTangents(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                               std::span<const glm::vec2> uv, std::span<uint32_t> indices);

}  // namespace latelight::scene
