// The inputs of a scene::Mesh: separate vertex streams, as in files and programs.
#pragma once

#include <span>
#include <vector>

#include "scene/scene.h"
#include "scene/tangents.h"

namespace latelight::scene {

// Each stream is empty or has one element per vertex.
struct Vertices {
  std::vector<vec3> positions, normals;
  std::vector<vec4> tangents, colors;
  std::vector<vec2> uv[2];
  std::vector<uint32_t> origin;  // per vertex, its index in the original streams
};

// Fills in flat normals as glTF 2.0 (3.7.2.1) specifies if they are missing, zero or not finite.
void makeFlatNormals(Vertices& vertices, std::vector<uint32_t>& indices);
// Inverts normals that point more than 120 degrees away from the front of every triangle around their vertex, and the
// handedness of their tangents. Returns a flag per vertex for inverted normals, or an empty vector if there are none.
std::vector<bool> repairNormals(Vertices& vertices, const std::vector<uint32_t>& indices);
// Invalid tangents become zero, so that the normal map has no effect there.
void repairTangents(std::vector<vec4>& tangents);
// Generates tangents for this space, unless the vertices lack its texture coordinates; may add vertices.
void makeTangents(const TangentSpace& space, Vertices& vertices, std::vector<uint32_t>& indices);

// Packs the streams into a mesh without bounds and name. Normals must exist.
Mesh pack(Vertices vertices, std::vector<uint32_t> indices);

// How the vertices of a mesh follow from the streams that it was created from.
struct VertexSources {
  std::vector<uint32_t> origin;  // per vertex, its index in the streams
  std::vector<bool> turned;      // by index in the streams: the normal was inverted; empty if none was
  bool flatNormals = false;      // normals are those of the triangles, which share no vertices
};

// Creates a mesh from streams, of which only positions are required. Missing normals are those of the triangles;
// missing tangents follow the first texture coordinates, if there are any. Fills `sources` unless it is null.
Mesh makeMesh(Vertices vertices, std::vector<uint32_t> indices, VertexSources* sources = nullptr);

// Scales the weights of a vertex's joints to a sum of 1, which quantized weights only approximate. Negative weights
// count as 0. If none is above 0, the first joint gets all.
void normalizeWeights(std::span<float> weights);

}  // namespace latelight::scene
