// Square tiles of an atlas.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace latelight::render {

struct AtlasTile {
  uint32_t x, y, size;
};
struct AtlasPlan {
  uint32_t width = 0, height = 0;
  std::vector<AtlasTile> tiles;  // in the order of the sizes
};

// Sides are powers of two of at least kLeastShadowTile. Packed without a gap along a Morton curve, largest first; the
// atlas is the smallest square of a power of two that holds them, or half of it.
inline constexpr uint32_t kLeastShadowTile = 32;
AtlasPlan packAtlas(std::span<const uint32_t> sizes);

}  // namespace latelight::render
