// Which blended materials let nothing through: alpha is 1 in the base color factor, at every texel of its texture, and
// at every vertex that is drawn with it. Exporters write many such materials, and they are drawn as opaque ones.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::render {

class Opacity {
 public:
  explicit Opacity(const scene::Scene& scene);

  // Follows edits of these meshes and of any instances. Returns the materials whose vertices have changed, in order.
  std::vector<uint32_t> update(std::span<const uint32_t> meshes);
  // Follows textures that were replaced, added or removed. Returns the blended materials that sample them, in order.
  std::vector<uint32_t> updateTextures(std::span<const uint32_t> textures);
  // `data`: the material's, or what a pose makes of it.
  bool isOpaque(uint32_t material, const shared::Material& data) const;

 private:
  std::vector<bool> materialsOfMeshes() const;
  bool hasOpaqueTexels(int texture) const;

  const scene::Scene& scene_;
  std::vector<uint8_t> meshes_;  // 1: with a vertex color whose alpha is below 1
  std::vector<bool> materials_;  // that draw such a mesh; empty where no mesh is such
  mutable std::map<int, bool> textures_;  // caches whether alpha is 1 at every texel
};

}  // namespace latelight::render
