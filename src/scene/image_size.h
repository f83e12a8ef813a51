// Sizes of textures and of their mip chains.
#pragma once

#include <cstddef>
#include <cstdint>

namespace latelight::scene {

struct ImageSize {
  uint32_t width = 0, height = 0;
};

// Maximum side of a texture, which every known Vulkan device supports.
inline constexpr uint32_t kMaxTextureSide = 16384;

// Return the number of levels of the full mip chain, and the total bytes of all levels as RGBA with 8 bits per channel.
uint32_t mipLevelCount(ImageSize size);
size_t mipChainBytes(ImageSize size);

}  // namespace latelight::scene
