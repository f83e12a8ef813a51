// Decodes the images of textures, and converts those of KHR_materials_pbrSpecularGlossiness.
#include "scene/gltf/texture.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/textures/texture.h"
#include "shared/color.h"

namespace latelight::scene::gltf {
namespace {

// --- KHR_materials_pbrSpecularGlossiness -----------------------------------------------------------------------------

const uint8_t* texelOf(const Texture& texture, ImageSize of, uint32_t x, uint32_t y) {
  // Nearest texel if the sizes differ.
  const size_t column = size_t{x} * texture.width / of.width, row = size_t{y} * texture.height / of.height;
  return reinterpret_cast<const uint8_t*>(texture.pixels.get()) + 4 * (row * texture.width + column);
}

template <typename Make>
Texture makeTexels(ImageSize size, bool srgb, const std::string& name, Make make) {
  Texture texture = scene::makeTexture(size, srgb, name);
  auto* texels = reinterpret_cast<uint8_t*>(texture.pixels.get());
  parallelFor(size.height, 64, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (uint32_t x = 0; x < size.width; ++x) make(x, uint32_t(y), texels + 4 * (y * size.width + x));
  });
  buildMips(texture);
  return texture;
}

Texture makeRoughness(const Texture& source, float glossiness) {
  const ImageSize size{source.width, source.height};
  return makeTexels(size, false, source.name + " as roughness", [&](uint32_t x, uint32_t y, uint8_t* texel) {
    const float rough = 255 - glossiness * texelOf(source, size, x, y)[3];
    std::fill_n(texel, 4, uint8_t{255});
    texel[1] = uint8_t(std::lround(std::clamp(rough, 0.0f, 255.0f)));
  });
}

// Diffuse reflectance is attenuated by 1 minus the largest channel of the reflectance at normal incidence.
Texture makeDiffuse(const Texture* diffuse, const Texture& specular, const std::array<float, 3>& factor) {
  ImageSize size{specular.width, specular.height};
  if (diffuse) size = {std::max(size.width, diffuse->width), std::max(size.height, diffuse->height)};
  std::array<float, 256> linear;
  for (size_t i = 0; i < 256; ++i) linear[i] = shared::linearFromSrgb(float(i) / 255);
  return makeTexels(size, true, (diffuse ? *diffuse : specular).name + " as diffuse color",
                    [&](uint32_t x, uint32_t y, uint8_t* texel) {
                      constexpr uint8_t kWhite[4] = {255, 255, 255, 255};
                      const uint8_t* from = diffuse ? texelOf(*diffuse, size, x, y) : kWhite;
                      const uint8_t* s = texelOf(specular, size, x, y);
                      float most = 0;
                      for (size_t c = 0; c < 3; ++c) most = std::max(most, factor[c] * linear[s[c]]);
                      for (size_t c = 0; c < 3; ++c) {
                        const float left = linear[from[c]] * std::max(1 - most, 0.0f);
                        texel[c] = uint8_t(std::lround(shared::srgbFromLinear(left) * 255));
                      }
                      texel[3] = from[3];
                    });
}

// --- images ----------------------------------------------------------------------------------------------------------

const ImageSource& sourceOf(const Document& document, int image) {
  const ImageSource& source = document.images[size_t(image)];
  if (!source.problem.empty()) badInput("{}", source.problem);
  return source;
}

Texture decode(const Document& document, int image, bool srgb) {
  const ImageSource& source = sourceOf(document, image);
  return decodeTexture(source.encoded, srgb, source.name);
}

template <typename Of>
size_t sum(const Document& document, const TextureRequest& request, Of of) {
  size_t total = 0;
  for (const int image : {request.image, request.specular})
    if (image >= 0) total += of(sourceOf(document, image));
  return total;
}

}  // namespace

size_t encodedBytes(const Document& document, const TextureRequest& request) {
  return sum(document, request, [](const ImageSource& source) { return source.encoded.size(); });
}

size_t textureBytes(const Document& document, const TextureRequest& request) {
  return sum(document, request,
             [](const ImageSource& source) { return mipChainBytes(imageSize(source.encoded, source.name)); });
}

Texture makeTexture(const Document& document, const TextureRequest& request) {
  if (request.make == TextureRequest::Make::Plain) return decode(document, request.image, request.srgb);
  const Texture specular = decode(document, request.specular, true);
  if (request.make == TextureRequest::Make::Roughness) return makeRoughness(specular, request.factor[0]);
  if (request.image < 0) return makeDiffuse(nullptr, specular, request.factor);
  const Texture diffuse = decode(document, request.image, true);
  return makeDiffuse(&diffuse, specular, request.factor);
}

}  // namespace latelight::scene::gltf
