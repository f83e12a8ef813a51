#include "scene/image_size.h"

#include <algorithm>
#include <bit>

namespace latelight::scene {

uint32_t mipLevelCount(ImageSize size) {
  return uint32_t(std::bit_width(std::max(size.width, size.height)));
}

size_t mipChainBytes(ImageSize size) {
  size_t pixels = 0;
  for (uint32_t level = 0; level < mipLevelCount(size); ++level)
    pixels += size_t(std::max(1u, size.width >> level)) * std::max(1u, size.height >> level);
  return pixels * 4;
}

}  // namespace latelight::scene
