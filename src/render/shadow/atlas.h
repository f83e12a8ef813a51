// Square tiles in the layers of an atlas, handed out and taken back.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

namespace latelight::render {

inline constexpr uint32_t kLeastShadowTile = 32;

struct AtlasTile {
  uint32_t layer, y, x, size;  // texels
  auto operator<=>(const AtlasTile&) const = default;
};

// Sides are powers of two from kLeastShadowTile to the layers' own. A free tile is cut in four until it is as small as
// asked, and four that are free again become one (a buddy system, Knowlton 1965, A Fast Storage Allocator, CACM 8(10)).
// Tiles that are taken in falling order of size leave no gap.
class AtlasTiles {
 public:
  AtlasTiles(uint32_t side, uint32_t layers);
  std::optional<AtlasTile> take(uint32_t size);  // nothing: no room
  void giveBack(const AtlasTile& tile);

 private:
  uint32_t side_;
  std::map<uint32_t, std::set<AtlasTile>> free_;  // by size
};

}  // namespace latelight::render
