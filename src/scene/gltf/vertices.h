// A primitive during conversion to a scene::Mesh: its data, and how they are read.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "scene/gltf/accessor.h"
#include "scene/gltf/mesh.h"
#include "scene/vertices.h"

namespace latelight::scene::gltf {

// The locations of a primitive's data.
struct Source {
  std::string name;  // "meshes[2].primitives[0]"
  std::map<std::string, Elements> attributes;
  std::vector<uint32_t> indices;  // a triangle list, counted from `first`
  size_t first = 0, count = 0;    // the vertices that the indices use
};

// gltf/topology.cpp: finds the data, decodes Draco, unrolls strips and fans, checks every index.
Source readSource(const Document& document, const tinygltf::Primitive& primitive, std::string name);

// Elements of an attribute of the source, or of a morph target's ("targets[1].NORMAL"), repaired where they are not
// finite: the value then is `otherwise` in all components.
template <int N>
std::vector<glm::vec<N, float>> readAttribute(const Document& document, const Source& source, const std::string& key,
                                              const Elements& elements, float otherwise = 0, float fill = 0) {
  bool anyBroken = false;
  auto values = readRepaired<N>(elements, source.first, source.count, anyBroken, otherwise, fill);
  if (anyBroken) document.repairs.add(fmt::format("{}.{}", source.name, key));
  return values;
}

// gltf/pose.cpp: adds weighted morph targets, of positions, normals and tangents only where `geometry`.
void applyMorphTargets(const Document& document, const tinygltf::Primitive& primitive, const Source& source,
                       const std::vector<double>& weights, bool geometry, Vertices& vertices);
// gltf/pose.cpp: the same as data, for vertices that come from `origin`. Nothing where a primitive has no weights.
void readSkinWeights(const Document& document, int skin, const Source& source, const std::vector<uint32_t>& origin,
                     Deformation& deformation);
void readMorphTargets(const Document& document, const tinygltf::Primitive& primitive, const Source& source,
                      const std::vector<uint32_t>& origin, Deformation& deformation);
// From bind space to the file's own frame, for each joint, with the nodes at rest.
std::vector<mat4> restJoints(const Document& document, const Hierarchy& hierarchy, int skin);

}  // namespace latelight::scene::gltf
