// Materials, and the textures they use.
#pragma once

#include <map>
#include <vector>

#include "scene/gltf/texture.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Each kind of use of an image becomes one scene texture.
class TextureTable {
 public:
  // Index into Scene::textures.
  int request(const TextureRequest& request);
  const std::vector<TextureRequest>& requests() const { return requests_; }

 private:
  std::map<TextureRequest, int> known_;
  std::vector<TextureRequest> requests_;
};

// Fills scene.materials, with textures in the slots that are wanted (LoadOptions::textureSlots), and those of
// scene.rig.materials that animations change.
void readMaterials(const Document& document, uint32_t slots, TextureTable& textures, Scene& scene);

// glTF 2.0, 3.9.6: for primitives without a material.
Material defaultMaterial();

// Index of the variant of that name, -1 for an empty name. Throws Error(Usage) listing the names if there is none.
// Fills scene.variants.
int readVariants(const Document& document, const std::string& wanted, Scene& scene);

// The material of a primitive under a variant (-1: the default), or -1.
int materialOf(const tinygltf::Primitive& primitive, int variant);

}  // namespace latelight::scene::gltf
