// Decodes images to textures and generates mip levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "scene/image_size.h"
#include "scene/scene.h"

namespace latelight::scene {

// Returns the size of an encoded image (JPEG, PNG, WebP, KTX2, AVIF, BMP, TGA, GIF; recognized by its first bytes,
// regardless of its name) from its header. Throws Error(BadInput) with `name` if it has another format, is broken, or
// is larger than kMaxTextureSide.
ImageSize imageSize(std::span<const std::byte> encoded, const std::string& name);

// Decodes an image and generates its mip levels unless it contains all of them. If a texture decoded from the same
// bytes still exists, their pixels are shared and must not be changed. Images with 16 bits per channel are rounded to
// 8. Throws Error(BadInput) with `name` if it is broken. The levels are generated on all threads; may be called from
// parallelFor.
Texture decodeTexture(std::span<const std::byte> encoded, bool srgb, const std::string& name);

// Allocates storage for all levels of a texture of that size, with uninitialized pixels.
Texture makeTexture(ImageSize size, bool srgb, const std::string& name);

// Fills every level except the first with a box filter, which is exact for odd sizes too, in linear light if the
// texture is sRGB.
void buildMips(Texture& texture);

}  // namespace latelight::scene
