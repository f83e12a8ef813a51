// Writes meshes to a glTF document.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// A primitive of a glTF mesh: a mesh of the scene with a material, which variants may replace.
struct Primitive {
  uint32_t mesh = 0;
  int material = -1;                               // in the document
  std::vector<std::pair<uint32_t, int>> variants;  // variant, and the material in the document
  auto operator<=>(const Primitive&) const = default;
};

// True for meshes without triangles, which glTF cannot hold: accessors have at least one element.
inline bool isEmpty(const scene::Mesh& mesh) {
  return mesh.positions.empty() || mesh.indices.size() < 3;
}

class MeshWriter {
 public:
  MeshWriter(const scene::Scene& scene, Document& document) : scene_(scene), document_(document) {}
  // Returns the index of the glTF mesh, which equal requests share. The meshes of the primitives must not be empty.
  size_t add(const std::string& name, const std::vector<Primitive>& primitives);

 private:
  const scene::Mesh& meshAt(uint32_t index) const;
  Json restWeightsOf(const std::vector<Primitive>& primitives) const;
  Json geometryOf(uint32_t mesh, size_t targets);
  Json attributesOf(const scene::Mesh& mesh);
  void addSkin(const scene::Deformation& deformation, Json& attributes);
  Json targetsOf(const scene::Deformation& deformation, size_t vertices, size_t count);

  const scene::Scene& scene_;
  Document& document_;
  std::map<std::pair<std::string, std::vector<Primitive>>, size_t> known_;
  std::map<std::pair<uint32_t, size_t>, Json> geometry_;  // by mesh and number of morph targets
};

}  // namespace latelight::exports
