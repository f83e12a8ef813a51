// A mesh on its way to a scene::Mesh: separate streams, as files and programs have them.
#pragma once

#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// All empty, or one a vertex.
struct Vertices {
  std::vector<vec3> positions, normals;
  std::vector<vec4> tangents, colors;
  std::vector<vec2> uv[2];
  std::vector<uint32_t> origin;  // of each, its number in the streams it came from
};

// What glTF 2.0 (3.7.2.1) wants where normals are missing, and where they are zero or not finite.
void makeFlatNormals(Vertices& vertices, std::vector<uint32_t>& indices);
void repairNormals(Vertices& vertices, const std::vector<uint32_t>& indices);
// Those that are no directions become zero: there the normal map does nothing.
void repairTangents(std::vector<vec4>& tangents);
// Along these texture coordinates, one a vertex; may add vertices.
void makeTangents(std::span<const vec2> uv, Vertices& vertices, std::vector<uint32_t>& indices);

// Without bounds and a name. There are normals by now.
Mesh pack(Vertices vertices, std::vector<uint32_t> indices);

// From streams of which the positions alone are required: normals that are missing are those of the triangles, and
// tangents follow the first texture coordinates, where there are any.
Mesh makeMesh(Vertices vertices, std::vector<uint32_t> indices);

}  // namespace latelight::scene
