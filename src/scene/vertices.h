// The inputs of a scene::Mesh: separate streams, as in files and programs.
#pragma once

#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// Each empty, or one per vertex.
struct Vertices {
  std::vector<vec3> positions, normals;
  std::vector<vec4> tangents, colors;
  std::vector<vec2> uv[2];
  std::vector<uint32_t> origin;  // for each, its index in the original streams
};

// Fills in normals as in glTF 2.0 (3.7.2.1) where they are missing, zero or not finite.
void makeFlatNormals(Vertices& vertices, std::vector<uint32_t>& indices);
// Normals that point to the back of every triangle around their vertex, by more than 120 degrees from its front, are
// turned over, with the tangents' handedness. Returns a flag per vertex for those, or nothing where there are none.
std::vector<bool> repairNormals(Vertices& vertices, const std::vector<uint32_t>& indices);
// Invalid ones become zero: there the normal map has no effect.
void repairTangents(std::vector<vec4>& tangents);
// Along these texture coordinates, one per vertex; may add vertices.
void makeTangents(std::span<const vec2> uv, Vertices& vertices, std::vector<uint32_t>& indices);

// Without bounds and name. Normals must exist.
Mesh pack(Vertices vertices, std::vector<uint32_t> indices);

// From streams of which only positions are required: missing normals are those of the triangles, and tangents follow
// the first texture coordinates, where there are any.
Mesh makeMesh(Vertices vertices, std::vector<uint32_t> indices);

}  // namespace latelight::scene
