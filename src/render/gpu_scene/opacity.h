// Finds the blended materials that are fully opaque: alpha is 1 in the base color factor, at every texel of the base
// color texture, and at every vertex drawn with the material. Exporters write many such materials; they are rendered as
// opaque.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::render {

class Opacity {
 public:
  explicit Opacity(const scene::Scene& scene);

  // Follows edits of these meshes and of any instances. Returns the indices of the materials for which the test of
  // vertex colors changed, in ascending order.
  std::vector<uint32_t> update(std::span<const uint32_t> meshes);
  // Follows textures that were replaced, added or removed. Returns the indices of the blended materials that sample
  // them, in ascending order.
  std::vector<uint32_t> updateTextures(std::span<const uint32_t> textures);
  // `data`: the material's record, from the scene or from a pose.
  bool isOpaque(uint32_t material, const shared::Material& data) const;

 private:
  std::vector<bool> materialsOfMeshes() const;
  bool hasOpaqueTexels(int texture) const;

  const scene::Scene& scene_;
  std::vector<uint8_t> meshes_;           // by mesh; 1: a vertex color has an alpha below 1
  std::vector<bool> materials_;           // by material: used with such a mesh; empty if there is no such mesh
  mutable std::map<int, bool> textures_;  // by texture, cached: alpha is 1 at every texel
};

}  // namespace latelight::render
