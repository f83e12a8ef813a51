// Allocator of square tiles in the layers of the shadow atlas.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

namespace latelight::render {

inline constexpr uint32_t kMinShadowTile = 32;

struct AtlasTile {
  uint32_t layer, y, x, size;  // texels
  auto operator<=>(const AtlasTile&) const = default;
};

// A buddy allocator (Knowlton 1965, A Fast Storage Allocator, CACM 8(10)). The sizes of tiles are powers of two from
// kMinShadowTile to the side of a layer. take() splits a free tile into quarters until it has the requested size, and
// recycle() merges four free quarters. Tiles allocated in order of decreasing size leave no gaps.
class AtlasTiles {
 public:
  AtlasTiles(uint32_t side, uint32_t layers);
  std::optional<AtlasTile> take(uint32_t size);  // none if no tile of this size is free
  void recycle(const AtlasTile& tile);

 private:
  uint32_t side_;
  std::map<uint32_t, std::set<AtlasTile>> free_;  // by size
};

}  // namespace latelight::render
