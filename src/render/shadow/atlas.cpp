#include "render/shadow/atlas.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace latelight::render {

namespace {

// Bits 0, 2, 4, ... of x, together.
uint32_t everySecondBit(uint64_t x) {
  uint32_t gathered = 0;
  for (uint32_t i = 0; i < 32; ++i) gathered |= static_cast<uint32_t>(x >> (2 * i) & 1u) << i;
  return gathered;
}

}  // namespace

AtlasPlan packAtlas(std::span<const uint32_t> sizes) {
  std::vector<uint32_t> order(sizes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return sizes[a] > sizes[b]; });
  AtlasPlan plan;
  plan.tiles.resize(sizes.size());
  uint64_t cells = 0;  // of the smallest tile's size, taken so far: always a multiple of the next tile's count
  for (const uint32_t i : order) {
    plan.tiles[i] = {everySecondBit(cells) * kLeastShadowTile, everySecondBit(cells >> 1) * kLeastShadowTile, sizes[i]};
    const uint64_t side = sizes[i] / kLeastShadowTile;
    cells += side * side;
  }
  const uint64_t area = std::bit_ceil(std::max<uint64_t>(cells, 1));
  const auto bits = static_cast<uint32_t>(std::countr_zero(area));
  plan.width = kLeastShadowTile << ((bits + 1) / 2);
  plan.height = kLeastShadowTile << (bits / 2);
  return plan;
}

}  // namespace latelight::render
