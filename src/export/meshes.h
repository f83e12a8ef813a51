// Writes meshes to a glTF document.
#pragma once

#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// A primitive of a glTF mesh: a mesh of the scene with a material, which variants may replace.
struct Primitive {
  uint32_t mesh = 0;
  int material = -1;                               // in the document
  std::vector<std::pair<uint32_t, int>> variants;  // variant, and the material in the document
  bool omitsTangents = false;                      // loading generates them again
  auto operator<=>(const Primitive&) const = default;
};

// True for meshes without triangles, which glTF cannot hold: accessors have at least one element.
inline bool isEmpty(const scene::Mesh& mesh) {
  return mesh.positions.empty() || mesh.indices.size() < 3;
}

class MeshWriter {
 public:
  MeshWriter(const scene::Scene& scene, Document& document) : scene_(scene), document_(document) {}
  // Returns the mesh that is written: the one with its morph targets, also if nothing animates them.
  const scene::Mesh& meshAt(uint32_t index) const;
  // Returns the index of the glTF mesh, which equal requests share. The meshes of the primitives must not be empty.
  size_t add(const std::string& name, const std::vector<Primitive>& primitives);

 private:
  Json restWeightsOf(const std::vector<Primitive>& primitives) const;
  Json geometryOf(const Primitive& primitive, size_t targets);
  Json attributesOf(const scene::Mesh& mesh, bool omitsTangents);
  void addSkin(const scene::Deformation& deformation, Json& attributes);
  Json targetsOf(const scene::Deformation& deformation, size_t vertices, size_t count);

  const scene::Scene& scene_;
  Document& document_;
  std::map<std::pair<std::string, std::vector<Primitive>>, size_t> known_;
  // By mesh, number of morph targets, and Primitive::omitsTangents.
  std::map<std::tuple<uint32_t, size_t, bool>, Json> geometry_;
};

}  // namespace latelight::exports
