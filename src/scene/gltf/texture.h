// Converts a file's images to the scene's textures.
#pragma once

#include <array>
#include <compare>

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// The sources of a texture, and its derivation from them.
struct TextureRequest {
  enum class Make {
    Plain,      // the image unchanged
    Diffuse,    // diffuse color `image` (white if -1), attenuated by the specular reflectance of `specular`
    Roughness,  // from the glossiness of `specular`
  };
  int image = -1;
  bool srgb = false;
  Make make = Make::Plain;
  int specular = -1;                     // an image of KHR_materials_pbrSpecularGlossiness
  std::array<float, 3> factor{1, 1, 1};  // factors on its specular color, or the first one on its glossiness

  auto operator<=>(const TextureRequest&) const = default;
};

// Returns the total over all source images. Throws Error(BadInput) for images that cannot be read.
size_t encodedBytes(const Document& document, const TextureRequest& request);
size_t textureBytes(const Document& document, const TextureRequest& request);

Texture makeTexture(const Document& document, const TextureRequest& request);

}  // namespace latelight::scene::gltf
