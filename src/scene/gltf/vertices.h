// A primitive during conversion to a scene::Mesh: its data, and the functions that read them.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "scene/gltf/accessor.h"
#include "scene/gltf/accessor_types.h"
#include "scene/gltf/mesh.h"
#include "scene/vertices.h"

namespace latelight::scene::gltf {

// The locations of a primitive's data.
struct Source {
  std::string name;  // "meshes[2].primitives[0]"
  std::map<std::string, Elements> attributes;
  std::vector<uint32_t> indices;  // a triangle list, relative to `first`
  size_t first = 0, count = 0;    // the range of vertices that the indices use
};

// Locates the data, decodes Draco, unrolls strips and fans, and checks every index. (topology.cpp)
Source readSource(const Document& document, const file::Primitive& primitive, std::string name);

// Reads the elements of an attribute of the source, or of a morph target ("targets[1].NORMAL"). Elements that are not
// finite are repaired: all their components become `otherwise`.
template <int N>
std::vector<glm::vec<N, float>> readAttribute(const Document& document, const Source& source, const std::string& key,
                                              const Elements& elements, float otherwise = 0, float fill = 0) {
  bool anyBroken = false;
  auto values = readRepaired<N>(elements, source.first, source.count, anyBroken, otherwise, fill);
  if (anyBroken) document.repairs.add(fmt::format("{}.{}", source.name, key));
  return values;
}

// Adds the texture coordinates and colors of weighted morph targets, which a Deformation does not change.
// (pose.cpp)
void morphCoordinatesAndColors(const Document& document, const file::Primitive& primitive, const Source& source,
                               const std::vector<double>& weights, Vertices& vertices);
// Read skin weights, and the positions, normals and tangents of a morph target, as data for vertices that are copies of
// those in `origin`. readSkinWeights() reads nothing if a primitive has no weights. (pose.cpp)
void readSkinWeights(const Document& document, int skin, const Source& source, const std::vector<uint32_t>& origin,
                     Deformation& deformation);
MorphTarget readMorphTarget(const Document& document, const file::Primitive& primitive, size_t index,
                            const Source& source, const std::vector<uint32_t>& origin);
// Returns the transform of each joint from bind space to the file's own frame, with the nodes at rest.
std::vector<mat4> restJoints(const Document& document, const Hierarchy& hierarchy, int skin);

}  // namespace latelight::scene::gltf
