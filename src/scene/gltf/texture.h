// A file's images as the scene's textures.
#pragma once

#include <array>
#include <compare>

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// What a texture is made of.
struct TextureRequest {
  enum class Make {
    Plain,      // the image as it is
    Diffuse,    // of `image`, white where it is -1, what the specular reflection of `specular` leaves
    Roughness,  // of the glossiness of `specular`
  };
  int image = -1;
  bool srgb = false;
  Make make = Make::Plain;
  int specular = -1;                     // an image of KHR_materials_pbrSpecularGlossiness
  std::array<float, 3> factor{1, 1, 1};  // on its specular colour; the first, on its glossiness

  auto operator<=>(const TextureRequest&) const = default;
};

// Of all that it is made of. Throws Error(BadInput) for images that can't be read.
size_t encodedBytes(const Document& document, const TextureRequest& request);
size_t textureBytes(const Document& document, const TextureRequest& request);

Texture makeTexture(const Document& document, const TextureRequest& request);

}  // namespace latelight::scene::gltf
