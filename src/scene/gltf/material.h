// Reads materials, and collects the textures that they use.
#pragma once

#include <map>
#include <vector>

#include "scene/gltf/texture.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// The distinct uses of images, each of which becomes one scene texture.
class TextureTable {
 public:
  // Returns the request's index into Scene::textures.
  int request(const TextureRequest& request);
  const std::vector<TextureRequest>& requests() const { return requests_; }

 private:
  std::map<TextureRequest, int> known_;
  std::vector<TextureRequest> requests_;
};

// Fills scene.materials, with textures in the requested slots (LoadOptions::textureSlots), and the materials in
// scene.rig.materials that animations change.
void readMaterials(const Document& document, uint32_t slots, TextureTable& textures, Scene& scene);

// The material of primitives without one (glTF 2.0, 3.9.6).
Material defaultMaterial();

// Fills scene.variants. Returns the index of the variant of that name, or -1 for an empty name. Throws Error(Usage)
// with a list of the names if there is none of that name.
int readVariants(const Document& document, const std::string& requested, Scene& scene);

// Returns the material of a primitive under a variant (-1: the default), or -1 if it has none.
int materialOf(const file::Primitive& primitive, int variant);

}  // namespace latelight::scene::gltf
