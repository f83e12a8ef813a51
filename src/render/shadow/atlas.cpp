#include "render/shadow/atlas.h"

#include <array>

namespace latelight::render {

namespace {

std::array<AtlasTile, 4> quarters(const AtlasTile& tile) {
  const uint32_t half = tile.size / 2;
  return {{{tile.layer, tile.y, tile.x, half},
           {tile.layer, tile.y, tile.x + half, half},
           {tile.layer, tile.y + half, tile.x, half},
           {tile.layer, tile.y + half, tile.x + half, half}}};
}

}  // namespace

AtlasTiles::AtlasTiles(uint32_t side, uint32_t layers) : side_(side) {
  for (uint32_t layer = 0; layer < layers; ++layer) free_[side].insert({layer, 0, 0, side});
}

std::optional<AtlasTile> AtlasTiles::take(uint32_t size) {
  std::set<AtlasTile>& free = free_[size];
  if (free.empty()) {
    if (size >= side_) return std::nullopt;
    const std::optional<AtlasTile> larger = take(2 * size);
    if (!larger) return std::nullopt;
    for (const AtlasTile& quarter : quarters(*larger)) free.insert(quarter);
  }
  return free.extract(free.begin()).value();
}

void AtlasTiles::recycle(const AtlasTile& tile) {
  std::set<AtlasTile>& free = free_[tile.size];
  free.insert(tile);
  if (tile.size == side_) return;
  const uint32_t whole = 2 * tile.size;
  const AtlasTile parent{tile.layer, tile.y / whole * whole, tile.x / whole * whole, whole};
  for (const AtlasTile& quarter : quarters(parent))
    if (!free.contains(quarter)) return;
  for (const AtlasTile& quarter : quarters(parent)) free.erase(quarter);
  recycle(parent);
}

}  // namespace latelight::render
