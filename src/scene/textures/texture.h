// Pictures in, scene::Texture out: decoding and mip levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "scene/scene.h"

namespace latelight::scene {

struct ImageSize {
  uint32_t width = 0, height = 0;
};

// Largest side of a texture; also supported by every Vulkan device we know.
inline constexpr uint32_t kMaxTextureSide = 16384;

// Levels of the full mip chain, and the bytes of all of them as RGBA, 8 bits a channel.
uint32_t mipLevelCount(ImageSize size);
size_t mipChainBytes(ImageSize size);

// Size of an encoded picture (JPEG, PNG, WebP, KTX2, AVIF, BMP, TGA, GIF; by its first bytes, whatever its name says),
// from its header. Throws Error(BadInput) with `name` if it is of another format, broken, or larger than
// kMaxTextureSide.
ImageSize imageSize(std::span<const std::byte> encoded, const std::string& name);

// Decodes a picture and builds its mip levels where it does not have all of them itself, or shares those of a texture
// that was decoded from the same bytes and still lives: nobody may change them. Pictures of 16 bits a channel are
// truncated to 8. Throws Error(BadInput) with `name` if it is broken. The levels are built on all threads; may be
// called from parallelFor.
Texture decodeTexture(std::span<const std::byte> encoded, bool srgb, const std::string& name);

// Storage for all levels of a texture of that size; pixels are not initialised.
Texture makeTexture(ImageSize size, bool srgb, const std::string& name);

// Fills every level but the first: a box filter, exact for odd sizes too, in linear light where the texture is sRGB.
void buildMips(Texture& texture);

}  // namespace latelight::scene
