// Decoder of UASTC LDR 4x4, a simpler coding of a subset of ASTC (the specification of that name, Binomial 2020; the
// meaning of the values: Khronos Data Format 1.3, chapter 23).
#pragma once

#include <cstddef>
#include <span>

#include "scene/textures/texture.h"

namespace latelight::scene {

inline constexpr size_t kUastcBlockBytes = 16;

// Decodes an image of blocks, row by row, one per 4x4 texels or part of them. `srgb` selects ASTC's rounding of such
// colors. Throws BrokenTexture.
void decodeUastc(std::span<const std::byte> blocks, ImageSize size, bool srgb, std::byte* rgba);

}  // namespace latelight::scene
