// Decodes an encoded texture as materials do. Large sizes are skipped: tests of limits check their memory, and the time
// of a fuzz target is for its parser, not for the texels of images that a few bytes declare.
#pragma once

#include "fuzz/fuzz.h"
#include "scene/textures/texture.h"

namespace latelight::fuzz {

inline void decodeSmallTexture(std::span<const std::byte> encoded) {
  constexpr uint64_t kMaxTexels = 1 << 14;
  expectErrors({ExitCode::BadInput}, [&] {
    const scene::ImageSize size = scene::imageSize(encoded, "an image");
    if (uint64_t{size.width} * size.height > kMaxTexels) return;
    scene::decodeTexture(encoded, true, "an image");
    scene::decodeTexture(encoded, false, "an image");
  });
}

}  // namespace latelight::fuzz
